#include "core/reed/playability/guidance.hpp"

#include "core/haptic/chain/chain.hpp"
#include "core/haptic/device/simulated_device.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

using namespace tactus;
using namespace tactus::reed;

namespace {

constexpr double kBlock_s = 64.0 / 48000;
constexpr double kBorder = 0.50625; // between two nodes
constexpr double kSpacing = 1.0 / (GuidanceField::kNodes - 1);

/// The field of where a function of (y, z) is above 0.
template <class F> GuidanceField field_of(F quality) {
  GradientField nodes;
  nodes.resize(81, 81);
  for (std::size_t k = 0; k < nodes.rows(); ++k)
    for (std::size_t i = 0; i < nodes.columns(); ++i)
      nodes.node(i, k) = quality(nodes.y_of(i), nodes.z_of(k));
  GuidanceField field;
  field.build(nodes, 0);
  return field;
}

GuidanceField half_plane() {
  return field_of([](double y, double) { return kBorder - y; });
}

/// The force on a hand that has rested there for half a second.
PlaneForce force_at_rest(const GuidanceField& field, double y, double z, double playability) {
  Guidance guidance;
  guidance.set({});
  PlaneForce force;
  for (int i = 0; i < 400; ++i)
    force = guidance.advance(field, y, z, playability, kBlock_s);
  return force;
}

/// The force on a hand that has moved steadily along y and is now there.
PlaneForce force_at_velocity(const GuidanceField& field, double y, double velocity,
                             double playability) {
  Guidance guidance;
  guidance.set({.smoothing_s = 0, .slew_n_per_s = 1e9});
  PlaneForce force;
  for (int i = 100; i >= 0; --i)
    force = guidance.advance(field, y - velocity * kBlock_s * i, 0.5, playability, kBlock_s);
  return force;
}

/// Least and greatest y of a handle in the last second, led along y through the whole loop: 1 kHz
/// servo, 750 Hz blocks, the chain's interpolation, and a note that sounds.
std::pair<double, double> run_hand(haptic::SimulatedDevice& device, const GuidanceField& field,
                                   double seconds) {
  haptic::ChainSettings limits;
  limits.allowance_w = 0.05;
  haptic::ChainState chain;
  Guidance guidance;
  guidance.set({});
  double y = 0.5, lowest = 1, highest = 0;
  constexpr std::uint64_t kStep = 16; // samples
  const auto samples = static_cast<std::uint64_t>(seconds * 48000);
  for (std::uint64_t n = 0; n < samples; n += kStep) {
    const double time_s = static_cast<double>(n) / 48000;
    if (n % 48 == 0) {
      haptic::State state;
      REQUIRE(device.read({n / 48, time_s, 1e-3}, state));
      REQUIRE(
          device.write(step(chain, limits, {time_s, time_s, state.position, state.velocity, {}})));
      y = (state.position.y + 0.05) / 0.1;
      lowest = time_s > seconds - 1 ? std::min(lowest, y) : 1;
      highest = time_s > seconds - 1 ? std::max(highest, y) : 0;
    }
    if ((n + kStep) % 64 == 0) {
      const PlaneForce force = guidance.advance(field, y, 0.5, 0.7, kBlock_s);
      REQUIRE(command(chain, limits, {0, force.y, force.z}, time_s));
    }
  }
  return {lowest, highest};
}

} // namespace

TEST_CASE("the way to a disc is the way to its rim, and leads there") {
  const auto field =
      field_of([](double y, double z) { return 0.2 - std::hypot(y - 0.5, z - 0.5); });
  for (const double r : {0.12, 0.16, 0.24, 0.3, 0.4}) // a blur's width from the middle and on
    for (int i = 0; i < 12; ++i) {
      const double a = i * 0.52359877559829882;
      const double y = 0.5 + r * std::cos(a), z = 0.5 + r * std::sin(a);
      CHECK(std::abs(field.distance(y, z) - (r - 0.2)) < kSpacing);
      const Gradient slope = field.slope(y, z);
      // The rim is a staircase of nodes: two spacings of play over a way of 0.04.
      CHECK((slope.y * std::cos(a) + slope.z * std::sin(a)) > 0.9);
    }
}

TEST_CASE("neither axis nor side is special: field and force turn and mirror with the notes") {
  // A note off the diagonal, its mirror image in y = z, and that in y = 1/2.
  const auto disc = [](double at_y, double at_z) {
    return field_of([=](double y, double z) { return 0.17 - std::hypot(y - at_y, z - at_z); });
  };
  const auto field = disc(0.3, 0.55), swapped = disc(0.55, 0.3), mirrored = disc(0.7, 0.55);
  for (const double y : {0.0, 0.013, 0.2, 0.31, 0.45, 0.9, 1.0})
    for (const double z : {0.0, 0.39, 0.56, 0.7, 1.0}) {
      const double here = field.distance(y, z);
      CHECK(swapped.distance(z, y) == doctest::Approx(here).epsilon(1e-9));
      CHECK(mirrored.distance(1 - y, z) == doctest::Approx(here).epsilon(1e-9));
      const Gradient slope = field.slope(y, z), turned = swapped.slope(z, y);
      CHECK(std::abs(turned.z - slope.y) + std::abs(turned.y - slope.z) < 1e-9);
    }
  // A hand on its way across the note and past it, in either direction.
  Guidance guides[3];
  for (Guidance& guide : guides)
    guide.set({.smoothing_s = 0, .slew_n_per_s = 1e9});
  double largest_y = 0, largest_z = 0;
  for (int n = 0; n <= 300; ++n) {
    const double y = 0.3 + 0.35 * std::sin(0.03 * n), z = 0.55 - 0.3 * std::cos(0.02 * n);
    const PlaneForce force = guides[0].advance(field, y, z, 0.3, kBlock_s);
    const PlaneForce turned = guides[1].advance(swapped, z, y, 0.3, kBlock_s);
    const PlaneForce other = guides[2].advance(mirrored, 1 - y, z, 0.3, kBlock_s);
    CHECK(std::abs(turned.z - force.y) + std::abs(turned.y - force.z) < 1e-9);
    CHECK(std::abs(other.y + force.y) + std::abs(other.z - force.z) < 1e-9);
    largest_y = std::max(largest_y, std::abs(force.y));
    largest_z = std::max(largest_z, std::abs(force.z));
  }
  CHECK(largest_y > 0.5);
  CHECK(largest_z > 0.5);
}

TEST_CASE("a straight border is exact up to the plane's edge") {
  const auto field = half_plane();
  for (const double y : {0.0, 0.1, 0.503, 0.7, 1.0})
    for (const double z : {0.0, 0.3, 1.0}) {
      CHECK(field.distance(y, z) == doctest::Approx(y - kBorder).epsilon(1e-9));
      CHECK(field.slope(y, z).y == doctest::Approx(1).epsilon(1e-9));
      CHECK(std::abs(field.slope(y, z).z) < 1e-9);
    }
}

TEST_CASE(
    "silence pulls by the ceiling, a note by a wall inside its border, nothing where all is one") {
  struct Place {
    double from_border, playability, force; // sides, f_p, N
  };
  const auto field = half_plane();
  for (const Place& at : {Place{0.01, 0, -2}, Place{0.3, 0, -2}, Place{0.49, 0, -2}, // silence
                          Place{-0.06, 0.7, 0}, Place{-0.025, 0.7, -1}, Place{0, 0.7, -2},
                          // a note that should sound and does not draws on to twice the margin
                          Place{-0.04, 0.1, -2}, Place{-0.075, 0.1, -1}, Place{-0.12, 0.1, 0}}) {
    const PlaneForce force = force_at_rest(field, kBorder + at.from_border, 0.4, at.playability);
    INFO(at.from_border, " from the border, ", at.playability);
    CHECK(force.y == doctest::Approx(at.force).epsilon(1e-6));
    CHECK(std::abs(force.z) < 1e-9);
  }
  for (const double everywhere : {-1.0, 1.0})
    for (const double playability : {0.0, 0.7}) {
      const PlaneForce force = force_at_rest(field_of([&](double, double) { return everywhere; }),
                                             0.3, 0.6, playability);
      CHECK(std::hypot(force.y, force.z) == 0);
    }
}

TEST_CASE("a hand on its way out meets the wall earlier, one on its way in later") {
  const auto field = half_plane();
  const double y = kBorder - 0.025;
  // w = 1 + (D + t_a v)/m with D = -m/2; v = 0.5 sides/s at t_a = 30 ms is 0.3 m
  CHECK(force_at_velocity(field, y, 0, 0.7).y == doctest::Approx(-1.0).epsilon(1e-6));
  CHECK(force_at_velocity(field, y, 0.5, 0.7).y == doctest::Approx(-1.6).epsilon(1e-6));
  CHECK(force_at_velocity(field, y, -0.5, 0.7).y == doctest::Approx(-0.4).epsilon(1e-6));
}

TEST_CASE("half-way between two notes the force turns over smoothly") {
  const auto field =
      field_of([](double y, double) { return std::max(0.2 - y, y - 0.8); }); // two bands
  CHECK(std::abs(force_at_rest(field, 0.5, 0.5, 0).y) < 1e-6);
  CHECK(force_at_rest(field, 0.4, 0.5, 0).y == doctest::Approx(-2).epsilon(1e-3));
  CHECK(force_at_rest(field, 0.6, 0.5, 0).y == doctest::Approx(2).epsilon(1e-3));
  double before = force_at_rest(field, 0.4, 0.5, 0).y;
  for (double y = 0.41; y < 0.6; y += 0.01) {
    const double now = force_at_rest(field, y, 0.5, 0).y;
    CHECK(now >= before - 1e-6);
    CHECK(now - before < 1.3); // 4 N over a blur of 2 x 0.015
    before = now;
  }
}

TEST_CASE("a spring hand that reaches for silence rests F_max/K short of it, without a tremble") {
  for (const double stiffness : {50.0, 100.0, 200.0, 400.0}) {
    const auto field = half_plane();
    haptic::SimulatedDevice device;
    haptic::SimulatedDevice::Settings handle;
    handle.hand = {.stiffness_n_per_m = stiffness, .damping_n_s_per_m = 1};
    device.set(handle);
    const Vec3 goal{0, 0.045, 0};
    device.set_path(haptic::RowPath({{0, {}, 0}, {2, goal, 0}}));
    device.set_state({}, {});
    const auto [lowest, highest] = run_hand(device, field, 4);
    // Outside the wall, or within it: K (goal - x) = F_max min(1, 1 + D/m), D = x/side - border.
    const double m = 0.05, border = 0.00625, side = 0.1, x_goal = goal.y;
    double x = x_goal - 2 / stiffness;
    if (x / side < border)
      x = (stiffness * x_goal - 2 * (1 - border / m)) / (stiffness + 2 / (m * side));
    CHECK(0.1 * (highest - lowest) < 20e-6);
    CHECK(0.1 * (0.5 * (highest + lowest) - 0.5) == doctest::Approx(x).epsilon(5e-3));
  }
}

TEST_CASE("a handle that nobody holds comes to rest in a note however narrow") {
  for (const double width : {0.02, 0.04, 0.08, 0.2})
    for (const double mass : {0.1, 0.4}) {
      const auto field =
          field_of([&](double y, double) { return 0.5 * width - std::abs(y - 0.5); });
      haptic::SimulatedDevice device;
      haptic::SimulatedDevice::Settings handle;
      handle.mass_kg = mass;
      handle.hand.hold = haptic::HandSettings::Hold::kFree;
      device.set(handle);
      device.set_state({0, 0.02, 0}, {}); // 20 mm beside its middle
      const auto [lowest, highest] = run_hand(device, field, 4);
      CAPTURE(width);
      CAPTURE(mass);
      CHECK(std::abs(0.5 * (lowest + highest) - 0.5) < 0.5 * width);
      CHECK(0.1 * (highest - lowest) < 0.5e-3); // a quarter of a millimetre to each side
    }
}

TEST_CASE("the slopes' force law is linear for small slopes and ends at its ceiling") {
  const PlaneForce small = gradient_force({0.01, -0.02}, 0.3, 1);
  CHECK(small.y == doctest::Approx(0.003).epsilon(1e-4));
  CHECK(small.z == doctest::Approx(-0.006).epsilon(1e-4));
  const PlaneForce large = gradient_force({40, -1e9}, 0.3, 1);
  CHECK(large.y == doctest::Approx(1));
  CHECK(large.z == doctest::Approx(-1));
}

TEST_CASE("a smoothed force follows a small step with its time constant, a large one by its slew") {
  ForceSmoother smoother;
  smoother.set(30e-3, 20);
  PlaneForce force;
  for (int i = 0; i < 30; ++i)
    force = smoother.advance({0.1, 0}, 1e-3);
  CHECK(force.y == doctest::Approx(0.1 * (1 - std::exp(-1.0))).epsilon(1e-9));
  smoother.reset();
  for (int i = 0; i < 10; ++i)
    force = smoother.advance({0, -1000}, 1e-3);
  CHECK(force.z == doctest::Approx(-0.2).epsilon(1e-9));
}

TEST_CASE("whatever comes in, the force is finite and within its ceiling") {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const auto field =
      field_of([](double y, double z) { return std::sin(40 * y) * std::sin(37 * z); });
  const GuidanceField unbuilt;
  Guidance guidance;
  guidance.set({});
  const double absurd[] = {nan, infinity, -infinity, 1e300, -1e300, 0, 0.5, 1, 1e-310};
  for (int round = 0; round < 3; ++round)
    for (const double y : absurd)
      for (const double z : absurd)
        for (const double playability : absurd) {
          const PlaneForce force =
              guidance.advance(round == 1 ? unbuilt : field, y, z, playability, kBlock_s);
          CHECK(std::isfinite(force.y));
          CHECK(std::hypot(force.y, force.z) <= 2 * std::sqrt(2.0));
        }
}
