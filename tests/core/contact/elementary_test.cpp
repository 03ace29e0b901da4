#include "core/contact/elementary.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>

using namespace tactus::contact;

TEST_CASE("powers are those of the mathematical library, over 300 decades") {
  double worst_exp2 = 0, worst_log2 = 0, worst_power = 0;
  for (double y = -990; y < 990; y += 0.37)
    worst_exp2 = std::max(worst_exp2, std::abs(exp2_of(y) / std::exp2(y) - 1));
  for (double x = 1e-150; x < 1e150; x *= 1.37) {
    worst_log2 = std::max(worst_log2, std::abs(log2_of(x) - std::log2(x)));
    for (const double e : {0.0, 0.15, 0.25, 0.5, 0.75, 1.0, 1.25, 0.9})
      worst_power = std::max(worst_power, std::abs(Power(e)(x) / std::pow(x, e) - 1));
  }
  CHECK(worst_exp2 < 1e-12);
  CHECK(worst_log2 < 1e-12);
  CHECK(worst_power < 1e-12 * 500);
  CHECK(exp2_of(-1e300) == exp2_of(-1000));
  CHECK(exp2_of(1e300) == exp2_of(1000));
}

TEST_CASE("a power that is followed stays within 1e-9 of the exact one, from wherever it begins") {
  for (const double e : {0.0, 0.1, 0.25, 0.65, 1.0, 1.5, 2.5})
    for (const double start : {1e-12, 1e-5, .02, 1., 1.03, 7., 600.}) {
      TaylorPower power(e);
      double worst = 0, x = start;
      for (int n = 0; n < 3000; ++n) {
        worst = std::max(worst, std::abs(power(x) / std::pow(x, e) - 1));
        x *= n < 400 ? (n % 100 < 50 ? 1.003 : .997 / 1.0001) // slowly, and then in leaps
                     : 1 + 0.03 * std::sin(0.37 * n) + (n % 500 == 0 ? 10 : 0) -
                           (n % 777 == 0 ? 0.9 : 0);
        x = std::clamp(x, 1e-50, 1e3);
      }
      CAPTURE(e);
      CAPTURE(start);
      CHECK(worst < 1e-9);
    }
}
