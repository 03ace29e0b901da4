#include "core/dsp/random.hpp"
#include "core/haptic/chain/velocity.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <limits>

using namespace tactus::haptic;
using tactus::Vec3;

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
  CHECK(norm(v - Vec3{0.2, -0.05, 0}) < 1e-8);
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
  CHECK(std::sqrt(adaptive / 1950) < 0.15 * std::sqrt(plain / 1950)); // RMS errors, m/s
}

TEST_CASE("a sudden stop is followed within a few ticks") {
  VelocityEstimator estimator;
  estimator.set_bound(2.5e-5);
  double v = 0;
  for (int i = 0; i < 50; ++i)
    v = estimator.update({0.2e-3 * i, 0, 0}, i * 1e-3).x;
  CHECK(v == doctest::Approx(0.2).epsilon(1e-6));
  for (int i = 50; i <= 53; ++i)
    v = estimator.update({0.2e-3 * 50, 0, 0}, i * 1e-3).x;
  CHECK(std::abs(v) < 0.02);
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
