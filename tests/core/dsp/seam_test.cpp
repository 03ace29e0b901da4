#include "core/dsp/seam.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

// Where one sound takes another's place.

using namespace tactus;

namespace {

constexpr double kRate = 48000, kOmega = 2 * std::numbers::pi * 440 / kRate;

/// Largest second difference: of a sine (w A)^2, of a jump its height, of a kink its angle.
double sharpest(const std::vector<double>& y) {
  double largest = 0;
  for (std::size_t n = 2; n < y.size(); ++n)
    largest = std::max(largest, std::abs(y[n] - 2 * y[n - 1] + y[n - 2]));
  return largest;
}

} // namespace

TEST_CASE("a sound that is exchanged at any phase neither jumps nor bends sharply") {
  for (const double next : {0.0, 1.0, 3.0}) // amplitude of what follows
    for (int cut = 1000; cut < 1110; cut += 7) {
      Seam seam;
      seam.prepare(kRate);
      std::vector<double> y;
      for (int n = 0; n < 2000; ++n) {
        if (n == cut)
          seam.cut();
        y.push_back(seam.next(n < cut ? std::sin(kOmega * n) : next * std::cos(kOmega * n)));
        if (n < cut || n >= cut + 240)
          CHECK(y.back() == (n < cut ? std::sin(kOmega * n) : next * std::cos(kOmega * n)));
      }
      CAPTURE(next);
      CAPTURE(cut);
      // The jump alone would be up to 3; a slope w A within the 24 samples of the correction is
      // 2 w A/24, and the half cosine bends by A (pi/240)^2/2.
      CHECK(sharpest(y) < (1 + next) * (kOmega * kOmega + 2.1 * kOmega / 24 + 2e-4));
    }
}

TEST_CASE("nothing is joined to silence") {
  Seam seam;
  seam.prepare(kRate);
  seam.cut();
  CHECK(seam.next(0.7) == 0.7);
  CHECK(seam.next(-0.2) == -0.2);
}
