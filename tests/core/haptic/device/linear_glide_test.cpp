#include "core/haptic/chain/velocity.hpp"
#include "core/haptic/device/linear_glide.hpp"
#include "tests/core/haptic/scene/scene_rig.hpp"

#include <doctest/doctest.h>

#include <limits>

using namespace tactus::haptic;
using tactus::Vec3;

namespace {

constexpr double kTick_s = 1e-3;

/// What a source that reports every `every` ticks says at tick n of a motion of `v` m/s.
Vec3 reported(int n, int every, const Vec3& v) { return v * (n / every * every * kTick_s); }

} // namespace

TEST_CASE("reports of a steady motion become that motion, 1.25 intervals late") {
  for (const int every : {1, 2, 8, 10, 16, 30}) {
    LinearGlide glide;
    const Vec3 v{0.2, -0.05, 0.3};
    for (int n = 0; n < 1000; ++n) {
      const double t = n * kTick_s;
      const Vec3 now = glide.update(reported(n, every, v), t);
      // A report is the position of its own tick, so the lag is that of the glide alone.
      if (n > 20 * every)
        CHECK(norm(now - v * (t - LinearGlide::kStretch * every * kTick_s)) < 1e-12);
    }
  }
}

TEST_CASE("after a pause the interval is the usual one; two reports at one instant take 1.25 ms") {
  LinearGlide glide;
  glide.update({}, 0);
  glide.update({0.01, 0, 0}, 0.5);
  const double usual_s = 0.0125; // 1.25 times 10 ms
  CHECK(glide.update({0.01, 0, 0}, 0.5 + 0.5 * usual_s).x == doctest::Approx(0.005));
  CHECK(glide.update({0.01, 0, 0}, 0.5 + 1.001 * usual_s).x == 0.01);
  LinearGlide twice;
  twice.update({}, 0);
  twice.update({0.01, 0, 0}, 0.01);
  twice.update({0.02, 0, 0}, 0.01);
  CHECK(twice.update({0.02, 0, 0}, 0.01 + 0.5 * 1.25e-3).x == doctest::Approx(0.01));
  CHECK(twice.update({0.02, 0, 0}, 0.01 + 1.26e-3).x == 0.02);
}

TEST_CASE("a stroke that is reported every 10 ms hits a body with its speed") {
  for (const bool gliding : {false, true}) { // false: what the glide is there for
    test::SceneRig rig;
    rig.add(Plane{});
    LinearGlide glide;
    VelocityEstimator estimator;
    for (std::uint64_t n = 0; n < 400; ++n) {
      const double t = static_cast<double>(n) * kTick_s;
      const Vec3 raw = Vec3{0, 0, 0.031} + reported(static_cast<int>(n), 10, {0, 0, -0.2});
      State state;
      state.position = gliding ? glide.update(raw, t) : raw;
      state.velocity = estimator.update(state.position, t);
      static_cast<void>(rig.model.force({n, t, kTick_s}, state));
    }
    double approach = -1;
    SceneEvent event;
    while (rig.model.events().pop(event))
      if (const auto* const hit = std::get_if<HitEvent>(&event))
        approach = hit->approach_m_per_s;
    CHECK(approach == (gliding ? doctest::Approx(0.2).epsilon(1e-6) : doctest::Approx(-1)));
  }
}

TEST_CASE("values that are not finite, and time that runs backwards, change nothing") {
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  LinearGlide glide;
  CHECK(glide.update({kNone, 0, 0}, 0) == Vec3{});
  CHECK(glide.update({1, 2, 3}, 1) == Vec3{1, 2, 3});
  for (const double bad : {kNone, kEndless, -kEndless}) {
    CHECK(glide.update({bad, 0, 0}, 2) == Vec3{1, 2, 3});
    CHECK(glide.update({5, 5, 5}, bad) == Vec3{1, 2, 3});
  }
  CHECK(glide.update({5, 5, 5}, 0.5) == Vec3{1, 2, 3});
  constexpr double kLargest = std::numeric_limits<double>::max();
  double t = 3;
  for (int n = 0; n < 200; ++n)
    CHECK(is_finite(
        glide.update(Vec3{1, 1, 1} * (n / 7 % 2 == 0 ? kLargest : -kLargest), t += kTick_s)));
  glide.reset();
  CHECK(glide.update({4, 4, 4}, 0) == Vec3{4, 4, 4});
}
