#include "core/dsp/soft_clip.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <limits>

using namespace tactus;

TEST_CASE("the soft clip is the identity up to one half, odd, rising and within 1 for any number") {
  double last = -1;
  for (double x = -20; x <= 20; x += 1.0 / 1024) {
    const double y = soft_clip(x);
    REQUIRE(y > last);
    REQUIRE(std::abs(y) < 1);
    REQUIRE(soft_clip(-x) == -y);
    if (std::abs(x) <= 0.5)
      REQUIRE(y == x);
    last = y;
  }
  CHECK(soft_clip(1) == 0.75);
  CHECK(soft_clip(std::numeric_limits<double>::infinity()) == 1);
  CHECK(soft_clip(-1e300) == -1);
  CHECK(std::isnan(soft_clip(std::numeric_limits<double>::quiet_NaN())));
}

TEST_CASE("its slope has no step where it begins") {
  constexpr double kStep = 1e-6;
  for (const double x : {kLinearLimit, -kLinearLimit}) {
    const double below = (soft_clip(x) - soft_clip(x - kStep)) / kStep;
    const double above = (soft_clip(x + kStep) - soft_clip(x)) / kStep;
    CHECK(std::abs(below - above) < 1e-5);
  }
}
