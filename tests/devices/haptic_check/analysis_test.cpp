#include "programs/haptic_check/analysis.hpp"
#include "programs/haptic_check/options.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <numbers>
#include <vector>

using namespace tactus::haptic_check;
using tactus::Vec3;

namespace {

constexpr double kPeriod_s = 1e-3;

/// Ticks on time, where position and force are functions of time.
template <class Position, class Force>
std::vector<Record> records(std::size_t count, Position position, Force force) {
  std::vector<Record> all;
  for (std::size_t i = 0; i < count; ++i) {
    const double t = kPeriod_s * static_cast<double>(i);
    Record record;
    record.index = i;
    record.time_s = 5 + t;
    record.position = position(t);
    record.force_n = force(t);
    all.push_back(record);
  }
  return all;
}

Vec3 none(double) { return {}; }

} // namespace

TEST_CASE("motion has a box, a smallest step and a share of new readings") {
  const auto all = records(
      100,
      [](double t) {
        return Vec3{1e-3 * std::floor(t * 500 + 0.25), -t, 0};
      },
      none);
  const Motion motion = motion_of(all);
  CHECK(motion.highest.x == doctest::Approx(0.049));
  CHECK(motion.lowest.y == doctest::Approx(-0.099));
  CHECK(motion.min_step_m == doctest::Approx(1e-3));
  CHECK(motion.changed_fraction == 1);
  const auto still = records(10, none, none);
  CHECK(motion_of(still).changed_fraction == 0);
  CHECK(motion_of({}).min_step_m == 0);
}

TEST_CASE("intervals are sorted by how far they are from the period") {
  auto all = records(5, none, none);
  all[1].time_s += 30e-6; // two intervals 30 us off
  all[4].time_s += 3e-3;  // one 3 ms off
  const Intervals intervals = intervals_of(all, kPeriod_s);
  CHECK(intervals.number == 4);
  CHECK(intervals.counts[0] == 1);
  CHECK(intervals.counts[1] == 2);
  CHECK(intervals.counts[7] == 1);
  CHECK(intervals.max_s == doctest::Approx(4e-3));
  CHECK(intervals.mean_s == doctest::Approx(1.75e-3));
}

TEST_CASE("a wall's stiffness, depth and hum come back") {
  const Wall wall{{0, -0.01, 0}, {0, 1, 0}};
  const double vibration_rms = 20e-6, stiffness = 400;
  const auto depth = [=](double t) {
    return 0.002 * std::sin(2 * std::numbers::pi * t) +
           vibration_rms * std::numbers::sqrt2 * std::sin(2 * std::numbers::pi * 120 * t);
  };
  const auto all = records(
      4000,
      [&](double t) {
        return Vec3{0, -0.01 - depth(t), 0};
      },
      [&](double t) {
        return Vec3{0, std::min(0.5, stiffness * std::max(0.0, depth(t))), 0};
      });
  const WallResult result = wall_result(all, wall, 1, 0.5, kPeriod_s);
  CHECK(result.stiffness_n_per_m == doctest::Approx(stiffness)); // where the limit is not reached
  CHECK(result.max_depth_m == doctest::Approx(0.002).epsilon(0.02));
  CHECK(result.max_force_n == doctest::Approx(0.5));
  // The slow sine of 1 Hz leaves less than a micrometre behind the parabola.
  CHECK(result.vibration_rms_m == doctest::Approx(vibration_rms).epsilon(0.08));
  CHECK(wall_result(all, {{0, -1, 0}, {0, 1, 0}}, 0, 1, kPeriod_s).ticks == 0);
  CHECK(wall_result({}, wall, 0, 1, kPeriod_s).ticks == 0);
}

TEST_CASE("the response at a frequency has amplitude and phase, whatever else moves") {
  const double omega = 2 * std::numbers::pi * 40;
  const auto all = records(
      1010,
      [&](double t) {
        return Vec3{0.01 + 3e-4 * std::sin(omega * t - 1.2), 7, 7};
      },
      [&](double t) {
        return Vec3{0.5 * std::sin(omega * t), 7, 7};
      });
  const Response response = response_at(all, 40, kPeriod_s);
  CHECK(response.force_n == doctest::Approx(0.5));
  CHECK(response.motion_m == doctest::Approx(3e-4));
  CHECK(response.phase_rad == doctest::Approx(-1.2));
  CHECK(response_at({all.data(), 10}, 40, kPeriod_s).force_n == 0); // not one turn
}

TEST_CASE("options are read, and what is none is refused") {
  const char* const words[] = {"haptic_check", "--device", "falcon:1", "--set", "firmware a.bin",
                               "--seconds",    "3",        "--force",  "2.5",   "--yes"};
  const ParsedOptions parsed = parse_options(10, words);
  CHECK(parsed.error == "");
  CHECK(parsed.options.device.driver == "falcon");
  CHECK(parsed.options.device.which == "1");
  REQUIRE(parsed.options.device.settings.size() == 1);
  CHECK(parsed.options.device.settings[0][1] == "a.bin");
  CHECK(*parsed.options.force_n == 2.5);
  CHECK(parsed.options.yes);
  const auto refused = [](std::initializer_list<const char*> more) {
    std::vector<const char*> all{"haptic_check"};
    all.insert(all.end(), more.begin(), more.end());
    return parse_options(static_cast<int>(all.size()), all.data()).error != "";
  };
  CHECK(refused({"--seconds"}));
  CHECK(refused({"--seconds", "0"}));
  CHECK(refused({"--force", "nan"}));
  CHECK(refused({"--force", "21"}));
  CHECK(refused({"--colour", "red"}));
  CHECK_FALSE(refused({}));
}
