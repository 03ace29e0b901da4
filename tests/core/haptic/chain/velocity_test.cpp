#include "core/dsp/random.hpp"
#include "core/haptic/chain/velocity.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace tactus::haptic;

TEST_CASE("a straight motion is estimated exactly, on uneven times too") {
  VelocityEstimator estimator;
  estimator.set_bound(1e-9);
  tactus::Random random(1);
  double t = 100;
  Vec3 v;
  for (int i = 0; i < 50; ++i) {
    t += 1e-3 * (1 + (random.next() % 4 == 0 ? 3 * random.uniform() : 0));
    v = estimator.update({0.2 * t, -0.05 * t, 0.3}, t);
  }
  CHECK(v.x == doctest::Approx(0.2).epsilon(1e-6));
  CHECK(v.y == doctest::Approx(-0.05).epsilon(1e-6));
  CHECK(v.z == doctest::Approx(0.0).epsilon(1e-9));
}

TEST_CASE("on a coarse encoder the estimate is many times quieter than a difference") {
  const double step = 5e-5, period = 1e-3;
  VelocityEstimator estimator;
  estimator.set_bound(step / 2);
  double adaptive = 0, plain = 0, previous = 0;
  for (int i = 0; i < 2000; ++i) {
    const double t = i * period;
    const double x = step * std::floor(0.02 * t / step + 0.5); // 20 mm/s: 0.4 steps a tick
    const double v = estimator.update({x, 0, 0}, t).x;
    if (i > 50) {
      adaptive += (v - 0.02) * (v - 0.02);
      plain += ((x - previous) / period - 0.02) * ((x - previous) / period - 0.02);
    }
    previous = x;
  }
  MESSAGE("RMS error at 20 mm/s: adaptive " << std::sqrt(adaptive / 1950) << ", difference "
                                            << std::sqrt(plain / 1950) << " m/s");
  CHECK(std::sqrt(adaptive) < 0.15 * std::sqrt(plain));
}

TEST_CASE("a sudden stop is followed within a few ticks") {
  VelocityEstimator estimator;
  estimator.set_bound(2.5e-5);
  double v = 0;
  int settled = -1;
  for (int i = 0; i < 100; ++i) {
    const double x = i < 50 ? 0.2e-3 * i : 0.2e-3 * 50;
    v = estimator.update({x, 0, 0}, i * 1e-3).x;
    if (i == 49)
      CHECK(v == doctest::Approx(0.2).epsilon(1e-6));
    if (i > 50 && settled < 0 && std::abs(v) < 0.02)
      settled = i - 50;
  }
  CHECK(settled > 0);
  CHECK(settled <= 3);
}

TEST_CASE("bad positions and times that stand still change nothing") {
  VelocityEstimator estimator;
  for (int i = 0; i < 20; ++i)
    estimator.update({0.001 * i, 0, 0}, i * 1e-3);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  CHECK(estimator.update({nan, 0, 0}, 1).x == doctest::Approx(1));
  CHECK(estimator.update({5, 0, 0}, 0.019).x == doctest::Approx(1));
  CHECK(estimator.update({5, 0, 0}, nan).x == doctest::Approx(1));
}
