#include "devices/falcon/kinematics.hpp"

#include "core/dsp/random.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace tactus::devices::falcon;
using tactus::dot;
using tactus::norm;
using tactus::Vec3;

namespace {

struct Pose {
  Counts counts;
  Vec3 position_mm;
  std::array<double, 3> torque_mn_m; // for the force (1, 0.5, -2) N
};
// Computed independently, by a numerical search and numerical differentiation.
constexpr Pose kPoses[] = {
    {{0, 0, 0}, {0, 0, 134.602428}, {-62.571043, -107.311850, 20.252518}},
    {{-500, -500, -500}, {0, 0, 110.754499}, {-59.120081, -95.375399, 8.820258}},
    {{500, 500, 500}, {0, 0, 156.860469}, {-55.630752, -106.304685, 35.760677}},
    {{-800, 200, 300}, {-7.517676, 38.330902, 122.122458}, {-96.365491, -94.135618, 56.725680}},
    {{100, -200, 300}, {18.232326, 3.978228, 136.133418}, {-63.243492, -121.733980, 48.728407}},
    {{350, -420, 15}, {20.539287, -18.467920, 130.093147}, {-35.110710, -123.519406, 18.978188}},
};

template <class Visit> void over_the_workspace(int points, Visit visit) {
  const auto at = [points](double low, double high, int i) {
    return low + (high - low) * i / (points - 1);
  };
  for (int i = 0; i < points; ++i)
    for (int j = 0; j < points; ++j)
      for (int k = 0; k < points; ++k)
        visit(Vec3{at(-0.045, 0.045, i), at(-0.045, 0.045, j), at(0.075, 0.165, k)});
}

// The force that the motors hold, from a numerical derivative of the inverse kinematics alone.
Vec3 held_force(const Vec3& p, const std::array<double, 3>& torque) {
  constexpr double h = 1e-7;
  Vec3 force;
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 plus = p, minus = p;
    plus[axis] += h;
    minus[axis] -= h;
    const auto high = inverse(plus), low = inverse(minus);
    if (!high || !low)
      return {NAN, NAN, NAN};
    for (std::size_t leg = 0; leg < 3; ++leg)
      force[axis] += torque[leg] * ((*high)[leg] - (*low)[leg]) / (2 * h);
  }
  return force;
}

double degrees_between(const Vec3& p, const Vec3& q) {
  const Vec3 cross{p.y * q.z - p.z * q.y, p.z * q.x - p.x * q.z, p.x * q.y - p.y * q.x};
  return std::atan2(norm(cross), dot(p, q)) * 180 / 3.14159265358979324;
}

} // namespace

TEST_CASE("encoder counts give positions and torques of an independent computation") {
  for (const Pose& pose : kPoses) {
    const Forward found = forward(motor_angles(pose.counts));
    REQUIRE(found.found);
    const auto torque = torques(found.position, {1, 0.5, -2});
    for (int axis = 0; axis < 3; ++axis) {
      CHECK(std::abs(found.position[axis] * 1e3 - pose.position_mm[axis]) < 1e-6);
      CHECK(std::abs(torque[static_cast<std::size_t>(axis)] * 1e3 -
                     pose.torque_mn_m[static_cast<std::size_t>(axis)]) < 1e-6);
    }
  }
}

TEST_CASE("forward undoes inverse all over the workspace") {
  int unreachable = 0, lost = 0, steps = 0;
  double worst = 0;
  over_the_workspace(20, [&](const Vec3& p) {
    const auto angles = inverse(p);
    if (!angles) {
      ++unreachable;
      return;
    }
    const Forward found = forward(*angles);
    lost += !found.found;
    steps = std::max(steps, found.steps);
    worst = std::max(worst, norm(found.position - p));
  });
  CHECK(lost == 0);
  CHECK(worst < 1e-12);
  CHECK(steps <= 8);
  CHECK(unreachable < 40);
}

TEST_CASE("the motors deliver the force that was asked for") {
  // Near the edge of the reach the angles bend sharply: central differences of 0.1 um are good to
  // some 1e-6 of the force there (of 1 um, to 3e-4), and 1e-8 in the middle.
  tactus::Random random(5);
  double worst_degrees = 0, worst_ratio = 0;
  int poses = 0;
  over_the_workspace(12, [&](const Vec3& p) {
    const Vec3 force{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5};
    const auto torque = torques(p, force);
    const Vec3 held = held_force(p, torque);
    if (!is_finite(held) || torque == std::array<double, 3>{})
      return;
    ++poses;
    worst_degrees = std::max(worst_degrees, degrees_between(held, force));
    worst_ratio = std::max(worst_ratio, std::abs(norm(held) / norm(force) - 1));
  });
  CHECK(poses > 1600);
  CHECK(worst_degrees < 0.01);
  CHECK(worst_ratio < 1e-4);
}

TEST_CASE("motors that saturate keep the force's direction") {
  tactus::Random random(6);
  double worst = 0;
  int saturated = 0;
  over_the_workspace(10, [&](const Vec3& p) {
    const Vec3 force =
        Vec3{random.uniform() - 0.5, random.uniform() - 0.5, random.uniform() - 0.5} *
        400; // far more than the motors can
    const Counts counts = motor_counts(torques(p, force), 10000);
    int largest = 0;
    std::array<double, 3> torque{};
    for (std::size_t motor = 0; motor < 3; ++motor) {
      largest = std::max(largest, std::abs(counts[motor]));
      torque[motor] = -counts[motor] / 10000.0;
    }
    CHECK(largest <= kMaxMotorCounts);
    const Vec3 held = held_force(p, torque);
    if (!is_finite(held) || largest == 0)
      return;
    ++saturated;
    worst = std::max(worst, degrees_between(held, force));
  });
  CHECK(saturated > 900);
  CHECK(worst < 0.1);
}

TEST_CASE("what cannot be reached is refused, and no input does harm") {
  CHECK_FALSE(inverse({0.3, 0, 0.1}).has_value());
  CHECK_FALSE(inverse({0, 0, 0.4}).has_value());
  CHECK_FALSE(inverse({NAN, 0, 0.1}).has_value());
  CHECK(torques({0, 0, 5}, {1, 2, 3}) == std::array<double, 3>{});
  CHECK(torques(kCentre, {INFINITY, 0, 0}) == std::array<double, 3>{});
  CHECK(motor_counts({NAN, 0, 0}, 10000) == Counts{});
  CHECK(motor_counts({1e300, 1e300, 0}, 1e300) == Counts{});
  tactus::Random random(7);
  for (int i = 0; i < 20000; ++i) {
    const auto count = [&] { return static_cast<std::int16_t>(random.next() >> 40); };
    const Forward found = forward(motor_angles({count(), count(), count()}));
    CHECK(found.steps <= 32);
    if (found.found)
      CHECK(is_finite(found.position));
  }
}

TEST_CASE("a reading is good to some hundredths of a millimetre") {
  // Half a count turns an upper arm of 60 mm by 0.318 mrad: 0.019 mm; three legs add up.
  CHECK(position_error_m() > 0.019e-3 / 2);
  CHECK(position_error_m() < 3 * 0.019e-3);
}

TEST_CASE("at the centre the motors hold some 8 N aside and twice that towards the user") {
  // At 10000 counts a N m: the largest force along each axis before a motor saturates.
  double most[3];
  for (int axis = 0; axis < 3; ++axis) {
    Vec3 force;
    force[axis] = 1;
    double largest = 0;
    for (const double torque : torques(kCentre, force))
      largest = std::max(largest, std::abs(torque));
    most[axis] = 0.4096 / largest;
  }
  CHECK(most[0] == doctest::Approx(7.7).epsilon(0.01));
  CHECK(most[1] == doctest::Approx(7.8).epsilon(0.01));
  CHECK(most[2] == doctest::Approx(16.9).epsilon(0.01));
}
