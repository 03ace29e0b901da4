#include "core/dsp/complex.hpp"
#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/effects/effect_model.hpp"
#include "core/haptic/servo/local_models.hpp"
#include "tests/approx.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <numbers>

using namespace tactus::haptic;
using std::numbers::pi;
using tactus::Random;
using tactus::Vec3;
using tactus::test::approx;

namespace {

/// Effects in a scene, asked tick by tick with the handle where the test says.
struct EffectRig {
  SceneModel scene;
  EffectModel effects;
  LocalModels<2> models{{&scene, &effects}};
  std::uint64_t ticks = 0;
  Vec3 last{};

  explicit EffectRig(const EffectSettings& settings = {}) {
    effects.set_scene(scene, models.force_of(0));
    effects.set(settings);
  }
  /// Force of the passive effects alone.
  Vec3 tick(const Vec3& position, double period_s = 1e-3) {
    State state;
    state.position = position;
    if (ticks > 0)
      state.velocity = (position - last) * (1 / period_s);
    last = position;
    const Vec3 sum = models.force({ticks, static_cast<double>(ticks) * period_s, period_s}, state);
    ++ticks;
    return sum - models.force_of(0);
  }
  void floor(double stiffness) { // z < 0 is solid
    auto world = std::make_unique<Scene>();
    world->bodies.push_back({1, Plane{}, {}, {stiffness, 0, 0}});
    scene.publish(std::move(world));
  }
};

/// Work that a force gives along a path, by trapezia, and what is exchanged at all.
struct Work {
  double given_j = 0, exchanged_j = 0;
  template <class Force, class Path> Work(int steps, Path&& path, Force&& force_at) {
    Vec3 before = path(0.0), force = force_at(before);
    for (int n = 1; n <= steps; ++n) {
      const Vec3 x = path(2 * pi * n / steps), next = force_at(x);
      given_j += dot((force + next) * 0.5, x - before);
      exchanged_j += std::abs(dot(next, x - before));
      before = x, force = next;
    }
  }
};

} // namespace

TEST_CASE(
    "constant and spring count as forces of the patch, and the spring is limited to its maximum") {
  EffectSettings settings;
  settings.constant = {{1, -2, 0.5}};
  settings.spring = {200, {0.01, 0, 0}, 1.5};
  EffectRig rig(settings);
  CHECK(rig.tick({0.005, 0.002, 0}) == Vec3{});
  CHECK(norm(rig.effects.active_force() - Vec3{2, -2.4, 0.5}) < 1e-12);
  rig.tick({-0.04, 0, 0});
  CHECK(norm(rig.effects.active_force() - Vec3{2.5, -2, 0.5}) < 1e-12); // 10 N, held to 1.5
  settings.spring.reset();
  rig.effects.set(settings);
  rig.tick({});
  CHECK(rig.effects.active_force() == Vec3{1, -2, 0.5});
  rig.effects.set({});
  rig.tick({});
  CHECK(rig.effects.active_force() == Vec3{});
}

TEST_CASE("viscous is -b v, limited to the device's damping limit at that period") {
  for (const double period_s : {2.5e-4, 1e-3, 5e-3}) {
    EffectSettings settings;
    settings.viscous = EffectSettings::Viscous{50};
    EffectRig rig(settings);
    const auto felt = [&](double limit) {
      rig.effects.set_damping_limit(limit);
      rig.tick({}, period_s);
      const Vec3 force = rig.tick({0.1 * period_s, 0, -0.2 * period_s}, period_s);
      CHECK(norm(force - Vec3{force.x, 0, -2 * force.x}) < 1e-12);
      return -force.x / 0.1; // 0.1 m/s
    };
    const double share = std::min(1.0, 1e-3 / period_s);
    CHECK(felt(20) == approx(20 * share));
    CHECK(felt(0) == approx(EffectModel::kDamping_n_s_per_m * share));
    CHECK(felt(1000) == approx(std::min(50.0, 1000 * share)));
  }
}

TEST_CASE("inertia has the impedance of a mass behind a spring and a damper") {
  // F/x = m w^2 (k + i w b)/(k + i w b - m w^2): the mass at low frequencies, k at high ones.
  for (const double hz : {0.5, 2.0, 8.0, 30.0}) {
    EffectSettings settings;
    settings.inertia = {0.4, 500, 2};
    EffectRig rig(settings);
    const double period = 1e-4, w = 2 * pi * hz; // fine ticks: the backward rule is of first order
    tactus::Complex sum = 0;
    const int turn = static_cast<int>(std::round(1 / (hz * period))), settle = 30000;
    for (int n = 0; n < settle + turn; ++n) {
      const double force = rig.tick({0, 1e-3 * std::sin(w * n * period), 0}, period).y;
      if (n >= settle)
        sum += force * exp(tactus::Complex(0, -w * n * period));
    }
    sum *= tactus::Complex(0, 2.0 / turn / 1e-3);
    const tactus::Complex coupling(500, w * 2), mass = 0.4 * w * w;
    const tactus::Complex theory = mass * coupling / (coupling - mass);
    CHECK(abs(sum - theory) < 0.02 * abs(theory));
  }
}

TEST_CASE("a free handle with inertia accelerates as both masses together, without oscillating") {
  for (const double mass : {0.01, 0.1, 0.5, 2.0, 10.0})
    for (const auto hold : {HandSettings::Hold::kFree, HandSettings::Hold::kSpring}) {
      SimulatedDevice device; // of 0.1 kg and 0.5 N s/m
      SimulatedDevice::Settings simulation;
      simulation.stops = false;
      simulation.hand.hold = hold;
      device.set(simulation);
      EffectSettings settings;
      settings.inertia = {mass};
      EffectRig rig(settings);
      const bool is_free = hold == HandSettings::Hold::kFree;
      double late = 0;
      Vec3 velocity_at{};
      for (std::uint64_t n = 0; n < 4000; ++n) {
        State state;
        REQUIRE(device.read({n, static_cast<double>(n) * 1e-3, 1e-3}, state));
        const double push = n < 50 ? 1 : 0; // a knock
        REQUIRE(device.write(rig.tick(state.position) + Vec3{push, 0, 0}));
        if (n == 1000)
          velocity_at = state.velocity;
        if (n > 3000)
          late = std::max(late, norm(state.velocity));
      }
      if (is_free && mass >= 0.1) // 50 mN s on M + m, slowed by 0.5 N s/m, since 25 ms
        CHECK(velocity_at.x ==
              approx(0.05 / (0.1 + mass) * std::exp(-0.5 * 0.975 / (0.1 + mass))).epsilon(0.1));
      CHECK(late <= (is_free ? 0.05 / (0.1 + mass) : 0.05));
    }
}

TEST_CASE("inertia and friction never return more energy than they got, for any parameters") {
  Random random(5);
  const auto in = [&random](double low, double high) {
    return low * std::pow(high / low, random.uniform());
  };
  for (int round = 0; round < 60; ++round) {
    EffectRig rig;
    EffectSettings settings;
    if (round % 2)
      settings.inertia = {in(1e-3, 20), in(1, 5000), round % 4 == 1 ? 0 : in(1e-3, 20)};
    else
      settings.friction = {in(0.01, 20), in(1, 5000)};
    Vec3 x{};
    for (int n = 0; n < 5; ++n) // they begin while the hand moves
      rig.tick(x += Vec3{2e-4, 0, 0});
    rig.effects.set(settings);
    double got = 0;
    for (int n = 0; n < 1000; ++n) {
      const Vec3 before = x;
      x += Vec3{random.uniform() - 0.5, random.uniform() - 0.5, std::sin(0.01 * n)} * 1e-4;
      got += dot(rig.tick(x), x - before);
      CHECK(got <= 1e-12);
    }
  }
}

TEST_CASE("friction holds like a spring, slips at its force, and holds again on the way back") {
  EffectSettings settings;
  settings.friction = {0.8, 400};
  EffectRig rig(settings);
  rig.tick({});
  CHECK(rig.tick({0.001, 0, 0}).x == approx(-0.4));
  for (int n = 0; n < 100; ++n)
    CHECK(rig.tick({0.002 + 1e-4 * n, 0, 0}).x == approx(-0.8));
  const double turn = 0.002 + 99e-4;
  CHECK(rig.tick({turn - 0.002, 0, 0}).x == approx(0).scale(1));
  CHECK(rig.tick({turn - 0.004, 0, 0}).x == approx(0.8));
  CHECK(norm(rig.tick({turn - 0.02, 0, 0.02})) == approx(0.8)); // one cone in all directions
}

TEST_CASE("texture is a sine of the position along its direction, and costs nothing round a closed "
          "path") {
  EffectSettings settings;
  const Vec3 along{0.6, 0, 0.8};
  settings.texture = {0.5, 2e-3, along};
  EffectRig rig(settings);
  CHECK(norm(rig.tick(along * 0.5e-3) - along * 0.5) < 1e-12); // a quarter of a ridge
  CHECK(norm(rig.tick(along * 1.0e-3)) < 1e-12);
  CHECK(norm(rig.tick(along * 1.5e-3 + Vec3{0, 0.01, 0}) + along * 0.5) < 1e-12);
  const Work circle(
      20000,
      [](double a) {
        return Vec3{0.01 * std::cos(a), 0, 0.01 * std::sin(a)};
      },
      [&rig](const Vec3& x) { return rig.tick(x); });
  CHECK(std::abs(circle.given_j) < 1e-8); // of 1 mJ along one ridge after another
}

TEST_CASE("relief cuts grooves into the touched body, and only there") {
  EffectSettings settings;
  settings.relief = {2e-4, 2e-3, {1, 0, 0}};
  EffectRig rig(settings);
  rig.floor(800);
  CHECK(rig.tick({0.3e-3, 0, 0.005}) == Vec3{});
  // 1 mm deep. On a ridge nothing changes; in a groove 0.2 mm are missing; on a flank h = -0.1 mm,
  // |h'| = pi H/lambda.
  CHECK(norm(rig.tick({0, 0, -1e-3})) < 1e-9);
  CHECK(norm(rig.tick({1e-3, 0, -1e-3}) - Vec3{0, 0, -0.16}) < 1e-8);
  const double pushed = 800 * (1e-3 - 1e-4), slope = pi * 2e-4 / 2e-3;
  CHECK(norm(rig.tick({0.5e-3, 0, -1e-3}) - Vec3{pushed * slope, 0, pushed - 0.8}) < 1e-8);
  // A direction that leans out of the surface counts by its part along it.
  EffectSettings leaning;
  leaning.relief = {2e-4, 2e-3, {0.6, 0, 0.8}};
  rig.effects.set(leaning);
  CHECK(norm(rig.tick({0.5e-3 / 0.6, 0, -1e-3}) - Vec3{0.6 * pushed * slope, 0, pushed - 0.8}) <
        1e-8);
  rig.effects.set(settings);
  // In the groove, above its ground: no force at all is left.
  const Vec3 felt = rig.tick({1e-3, 0, -1e-4});
  CHECK(norm(felt + rig.models.force_of(0)) < 1e-9);
  // A closed path through ridges and grooves, deep on the way there and shallow on the way back.
  const Work work(
      40000,
      [](double a) {
        return Vec3{3.3e-3 * std::cos(a), 0, -1e-3 + 0.9e-3 * std::sin(a)};
      },
      [&rig](const Vec3& x) { return rig.tick(x) + rig.models.force_of(0); });
  CHECK(std::abs(work.given_j) < 1e-5 * work.exchanged_j);
}

TEST_CASE("wild positions leave every effect finite") {
  Random random(2);
  constexpr double kInfinite = std::numeric_limits<double>::infinity();
  const double wild_values[] = {0, 1e300, -1e300, std::nan(""), 1e-310, 0.01, kInfinite};
  const auto wild = [&] { return wild_values[random.next() % std::size(wild_values)]; };
  EffectSettings settings;
  settings.spring = {5000, {}, 40};
  settings.viscous = {50};
  settings.inertia = {20, 5000, 20};
  settings.friction = {40, 1};
  settings.texture = {40, 5e-5, {1, 0, 0}};
  settings.relief = {1e-3, 1e-2, {0, 1, 0}};
  EffectRig rig(settings);
  rig.floor(800);
  for (int n = 0; n < 5000; ++n) {
    State state;
    state.position = {wild(), wild(), wild()};
    state.velocity = {wild(), wild(), wild()};
    if (n % 5 == 0)
      state.position = state.velocity = {1e-3, 1e-3, -1e-3};
    static_cast<void>(rig.models.force({static_cast<std::uint64_t>(n), n * 1e-3, 1e-3}, state));
    CHECK(is_finite(rig.models.force_of(1)));
    CHECK(norm(rig.models.force_of(1)) <= 6 * EffectModel::kMaxEffect_n);
    CHECK(is_finite(rig.effects.active_force()));
  }
}

TEST_CASE("a device opened at another position has no friction or mass of the last one") {
  EffectSettings settings;
  settings.friction = {5, 500};
  settings.inertia = {0.3, 300, 1};
  EffectRig rig(settings);
  for (int n = 0; n < 50; ++n)
    rig.tick({1e-4 * n, 0, 0});
  REQUIRE(norm(rig.tick({6e-3, 0, 0})) > 2);
  rig.models.begin();
  CHECK(rig.tick({0.04, 0, 0}) == Vec3{});
}
