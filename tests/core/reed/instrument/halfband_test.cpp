#include "core/reed/instrument/halfband.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kTwoPi = 2 * std::numbers::pi;

/// What n input samples become, in stretches of several lengths.
template <int pairs> std::vector<double> halved(const std::vector<double>& input) {
  Halfband<double, pairs, 64> filter;
  filter.reset();
  std::vector<double> output(input.size() / 2);
  int length = 1;
  for (std::size_t done = 0; done < output.size(); length = length % 31 + 1) {
    const auto count =
        std::min<std::size_t>(static_cast<std::size_t>(length), output.size() - done);
    filter.run(input.data() + 2 * done, output.data() + done, static_cast<int>(count));
    done += count;
  }
  return output;
}

/// Zero-phase response at f turns an input sample: the output against the input 2 pairs - 1 samples
/// before, and what is left at right angles to it.
template <int pairs> std::pair<double, double> response(double f) {
  std::vector<double> input;
  for (int n = 0; n < 4000; ++n)
    input.push_back(std::cos(kTwoPi * f * n));
  const std::vector<double> output = halved<pairs>(input);
  double in = 0, across = 0, cosines = 0, sines = 0, both = 0;
  for (int n = 100; n < 2000; ++n) {
    const double phase = kTwoPi * f * (2 * n - (2 * pairs - 1));
    const double y = output[static_cast<std::size_t>(n)], c = std::cos(phase), s = std::sin(phase);
    in += y * c, across += y * s;
    cosines += c * c, sines += s * s, both += c * s;
  }
  const double determinant = cosines * sines - both * both; // least squares of the two
  return {(in * sines - across * both) / determinant, (across * cosines - in * both) / determinant};
}

template <int pairs> void check() {
  // Kaiser's window at -70 dB: a transition of (70 - 7.95)/(14.36 (4 pairs - 2)) about a quarter.
  const double half = 0.5 * (70 - 7.95) / (14.36 * (4 * pairs - 2));
  for (const double f : {0.013, 0.5 * (0.25 - half), 0.25 - half}) {
    CHECK(response<pairs>(f).first == doctest::Approx(1).epsilon(4e-4));
    CHECK(std::abs(response<pairs>(f).second) < 1e-9); // linear phase
    CHECK(std::abs(response<pairs>(0.5 - f).first) < 8e-4);
  }
  for (const double f : {0.03, 0.11, 0.17, 0.21, 0.24}) // half-band: H(f) + H(1/2 - f) = 1
    CHECK(response<pairs>(f).first + response<pairs>(0.5 - f).first ==
          doctest::Approx(1).epsilon(1e-9));
  CHECK(halved<pairs>(std::vector<double>(200, 1.0)).back() == doctest::Approx(1).epsilon(1e-14));
  // Between them the window makes the response fall, through one half at the quarter.
  CHECK(response<pairs>(0.25 - 0.4 * half).first > 0.7);
  CHECK(response<pairs>(0.25 + 0.4 * half).first < 0.3);
}

} // namespace

TEST_CASE("the half-band filters halve the rate: flat, 70 dB, linear phase, at any cut") {
  check<4>();
  check<8>();
}

TEST_CASE("the decimator keeps what is below the sample rate's passband and nothing of the rest") {
  for (const int oversampling : {2, 4})
    for (const double share : {0.02, 0.3, 0.7, 0.9}) { // of the output's sample rate
      Decimator<double, 64> decimator;
      decimator.reset();
      double loudest = 0, energy = 0;
      const double f = share / oversampling;
      for (int block = 0; block < 200; ++block) {
        double signal[64], output[32];
        for (int i = 0; i < 16 * oversampling; ++i)
          signal[i] = std::sqrt(2) * std::sin(kTwoPi * f * (block * 16 * oversampling + i));
        decimator.run(oversampling, signal, output, 16);
        for (int i = 0; i < 16 && block > 20; ++i) {
          loudest = std::max(loudest, std::abs(output[i]));
          energy += output[i] * output[i] / (179 * 16);
        }
      }
      CAPTURE(oversampling);
      CAPTURE(share);
      if (share < 0.5)
        CHECK(energy == doctest::Approx(1).epsilon(0.01));
      else
        CHECK(loudest < 2e-3);
    }
}

} // namespace tactus::reed
