#include "core/reed/bore/steepening.hpp"

#include "tests/core/reed/render.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numbers>
#include <random>
#include <span>
#include <utility>
#include <vector>

// Waves of finite amplitude against weak-shock theory: Blackstock's series for the sine, and the
// definition of the equal-area rule worked out on a grid 64 times finer.

namespace tactus::reed {
namespace {

using test::component;
constexpr double kPi = std::numbers::pi;

/// What becomes of a wave in Pa, in runs of the given size; lead in s for each Pa.
std::vector<double> steepened(std::vector<double> wave, double rate, double lead, int size = 32) {
  Steepening steepening;
  steepening.prepare(rate);
  steepening.set_rate(rate);
  for (std::size_t at = 0; at < wave.size(); at += static_cast<std::size_t>(size))
    steepening.run(wave.data() + at,
                   std::min(size, static_cast<int>(wave.size()) - static_cast<int>(at)),
                   lead * rate);
  return wave;
}

std::vector<double> sampled(const std::function<double(double)>& wave, double seconds,
                            double rate) {
  std::vector<double> samples(static_cast<std::size_t>(seconds * rate));
  for (std::size_t n = 0; n < samples.size(); ++n)
    samples[n] = wave(static_cast<double>(n) / rate);
  return samples;
}

/// B_n of a sine of unit amplitude at sigma times the distance at which it breaks (Blackstock
/// 1966): Fubini's 2 J_n(n sigma)/(n sigma) before it, a sawtooth's 2/(n (1 + sigma)) far behind.
double blackstock(int n, double sigma) {
  double shock = 0; // phase of the wave where it meets the shock: shock = sigma sin shock
  if (sigma > 1)
    for (double low = 1e-9, high = kPi; high - low > 1e-13;) {
      const double middle = 0.5 * (low + high);
      (middle < sigma * std::sin(middle) ? low : high) = middle;
      shock = high;
    }
  constexpr int kSteps = 4000; // Simpson's rule
  double sum = 0;
  for (int i = 0; i <= kSteps; ++i) {
    const double phase = shock + (kPi - shock) * i / kSteps;
    sum += (i == 0 || i == kSteps ? 1
            : i % 2               ? 4
                                  : 2) *
           std::cos(n * (phase - sigma * std::sin(phase)));
  }
  sum *= (kPi - shock) / kSteps / 3;
  return 2 / (n * kPi) * std::sin(shock) + 2 / (n * kPi * sigma) * sum;
}

/// The definition: of all t the one with the largest int a dt - (t - tau)^2/(2 lead), where no
/// piece is as far off as the reach. Means over the samples, `delay` later.
std::vector<double> equal_areas(const std::function<double(double)>& wave, double seconds,
                                double rate, double lead, double delay) {
  constexpr int kFiner = 64;
  const double step = 1 / (kFiner * rate);
  const auto size = static_cast<std::size_t>(seconds / step);
  std::vector<double> integral(size + 1);
  for (std::size_t i = 0; i < size; ++i) // midpoints
    integral[i + 1] = integral[i] + step * wave((static_cast<double>(i) + 0.5) * step);
  const auto potential = [&](double tau) {
    const auto from = static_cast<std::size_t>(std::clamp((tau - Steepening::kMaxShift) / step, 0.0,
                                                          static_cast<double>(size))),
               to = static_cast<std::size_t>(std::clamp((tau + Steepening::kMaxShift) / step, 0.0,
                                                        static_cast<double>(size)));
    double largest = -1e300;
    for (std::size_t i = from; i <= to; ++i) {
      const double shift = static_cast<double>(i) * step - tau;
      largest = std::max(largest, integral[i] - 0.5 * shift * shift / lead);
    }
    return largest;
  };
  std::vector<double> means;
  for (double n = 0; n < seconds * rate; n += 1) {
    const double tau = (n - delay - 0.5) / rate;
    means.push_back(rate * (potential(tau + 1 / rate) - potential(tau)));
  }
  return means;
}

} // namespace

TEST_CASE("a sine steepens and breaks as Blackstock's series says, at any sample rate") {
  for (const double rate : {44100.0, 48000.0, 192000.0})
    for (const double sigma : {0.3, 0.8, 1.5, 3.0}) {
      const double frequency = 997, amplitude = 1000;
      const double lead = sigma / (2 * kPi * frequency * amplitude);
      REQUIRE(lead * amplitude < Steepening::kMaxShift);
      const auto sine = [&](double t) { return amplitude * std::sin(2 * kPi * frequency * t); };
      const std::vector<double> wave = steepened(sampled(sine, 0.1, rate), rate, lead);
      const auto late = std::span(wave).last(wave.size() / 2);
      for (int n = 1; n * frequency < 10e3; ++n) {
        const double expected = std::abs(blackstock(n, sigma));
        if (expected < 3e-3)
          continue;
        INFO("partial ", n, " at sigma ", sigma, ", ", rate, " Hz");
        // What interpolation and the window over a sample leave of 10 kHz at 44.1 kHz.
        const double found = abs(component(late, rate, n * frequency)) / amplitude;
        CHECK(std::abs(20 * std::log10(found / expected)) < (sigma < 1 ? 0.06 : 0.25));
      }
    }
}

TEST_CASE("where a wave overtakes itself it is cut at equal areas, without a spike") {
  // A crest that overtakes the one before it and a trough between them, as at a note's first loud
  // cycle: the shocks meet and merge.
  const auto wave = [](double t) {
    const auto bump = [t](double at, double width, double size) {
      return size * std::exp(-0.5 * std::pow((t - at) / width, 2));
    };
    return bump(4e-3, 2e-4, 900) - bump(4.6e-3, 1.5e-4, 1500) + bump(5.1e-3, 2e-4, 2200) -
           bump(6e-3, 4e-4, 1200);
  };
  constexpr double kRate = 48000;
  for (const double lead : {5e-8, 1.2e-7, 2.2e-7, 3.5e-7, 1e-6}) { // the last two to the reach
    Steepening steepening;
    steepening.prepare(kRate);
    steepening.set_rate(kRate);
    const std::vector<double> found = steepened(sampled(wave, 0.012, kRate), kRate, lead);
    const std::vector<double> expected = equal_areas(wave, 0.012, kRate, lead, steepening.delay());
    REQUIRE(found.size() == expected.size());
    double highest = 0, area = 0, worst = 0, wrong = 0;
    for (auto n = static_cast<std::size_t>(2 * steepening.delay()); n < found.size(); ++n) {
      const double error = found[n] - expected[n];
      highest = std::max(highest, std::abs(found[n]));
      area += error / kRate;
      worst = std::max(worst, std::abs(error));
      wrong += std::abs(error);
    }
    CAPTURE(lead);
    CHECK(highest < 1.1 * 2200); // the sharpening beside a shock
    CHECK(std::abs(area) < 1e-3 * 2200 * 2e-4 * std::sqrt(2 * kPi)); // of the largest crest
    // A shock's one sample is sharpened: nowhere else does it differ.
    CHECK(worst < 0.15 * 3700);
    CHECK(wrong < 4 * 0.15 * 3700);
  }
}

TEST_CASE("steepening does not depend on how the stream is cut, and a mean adds up to nothing") {
  const double rate = 48000, lead = 1.5e-7;
  const std::vector<double> wave = sampled(
      [](double t) {
        return 900 + 1500 * std::sin(2 * kPi * 147 * t) + 900 * std::sin(2 * kPi * 441 * t + 1);
      },
      4, rate); // the potential passes 1e8 Pa samples and is counted anew
  const std::vector<double> whole = steepened(wave, rate, lead, 64);
  for (const int size : {1, 7, 32})
    CHECK(steepened(wave, rate, lead, size) == whole);
  double mean = 0;
  for (std::size_t n = 48000; n < whole.size(); ++n)
    mean += whole[n] / static_cast<double>(whole.size() - 48000);
  CHECK(mean == doctest::Approx(900).epsilon(1e-4).scale(0)); // 147 Hz has whole periods in 3 s
}

TEST_CASE("a piece goes no farther than the reach, and a wave beyond it keeps its shape") {
  const double rate = 48000, lead = 1e-6; // 0.5 ms at 500 Pa
  Steepening steepening;
  steepening.prepare(rate);
  steepening.set_rate(rate);
  std::vector<double> wave = sampled(
      [](double t) { return t < 0.01 ? 0 : 4000 + 1000 * std::sin(2 * kPi * 300 * t); }, 0.1, rate);
  const std::vector<double> before = wave;
  for (std::size_t at = 0; at + 32 <= wave.size(); at += 32) // the lead breathes, as in a glide
    steepening.run(wave.data() + at, 32,
                   lead * rate * (1 + 0.01 * std::sin(0.1 * static_cast<double>(at))));
  CHECK(steepening.is_bounded());
  // 24 samples early, and half a sample between two of them.
  const auto late = static_cast<std::size_t>(steepening.delay() - 24 - 0.5);
  double worst = 0;
  for (std::size_t n = 2400; n < 4700; ++n)
    worst = std::max(worst, std::abs(wave[n] - 0.5 * (before[n - late] + before[n - late - 1])));
  CHECK(worst < 3); // Pa: what a sine of 300 Hz bends within half a sample
}

TEST_CASE("a steady pressure stays what it is, whatever its lead does") {
  // Also at the reach itself, where rounding may put a piece a hair beyond it.
  for (const double rate : {44100.0, 48000.0, 192000.0})
    for (const double pressure : {1000.0, 6000.0}) {
      Steepening steepening;
      steepening.prepare(192000);
      steepening.set_rate(rate);
      for (int i = 0; i < 600; ++i) {
        double wave[32];
        std::fill(std::begin(wave), std::end(wave), pressure);
        steepening.set_rate(rate); // the same: nothing begins anew
        steepening.run(wave, 32, (1.1e-7 + 1e-10 * i) * rate);
        if (i > 40)
          for (const double value : wave)
            REQUIRE(std::abs(value - pressure) < 1e-6);
      }
    }
}

TEST_CASE("steepening stays bounded for waves of any size and says when they are no numbers") {
  for (const auto& [size, lead] :
       {std::pair{1e-300, 0.3}, std::pair{1e5, 0.3}, std::pair{1e9, 1e-300}, std::pair{1e9, 0.0}}) {
    Steepening steepening;
    steepening.prepare(192000);
    steepening.set_rate(192000);
    std::mt19937 random(1);
    for (int run = 0; run < 200; ++run) {
      double wave[64];
      for (double& value : wave)
        value = std::uniform_real_distribution<>(-size, size)(random);
      steepening.run(wave, 64, lead);
      for (const double value : wave)
        REQUIRE(std::abs(value) < 6 * size); // noise, to which the quadrature is a filter
    }
    CHECK(steepening.is_bounded());
    double none[8] = {std::nan("")};
    steepening.run(none, 8, 0.1);
    CHECK_FALSE(steepening.is_bounded());
    steepening.reset();
    CHECK(steepening.is_bounded());
  }
}

} // namespace tactus::reed
