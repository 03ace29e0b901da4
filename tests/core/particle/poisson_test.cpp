#include "core/particle/cloud.hpp"
#include "core/particle/poisson_clock.hpp"
#include "core/particle/power_law.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <vector>

using namespace tactus;
using namespace tactus::particle;

namespace {

/// Times of the events of a constant rate, s.
std::vector<double> events(double rate_hz, double sample_rate, double seconds, std::uint64_t seed) {
  PoissonClock clock;
  Random random(seed);
  std::vector<double> times;
  const auto samples = static_cast<long>(seconds * sample_rate);
  for (long n = 0; n < samples; ++n)
    clock.advance(rate_hz / sample_rate, random, [&](double fraction) {
      times.push_back((static_cast<double>(n) + fraction) / sample_rate);
    });
  return times;
}

std::vector<double> differences(const std::vector<double>& times) {
  std::vector<double> waits;
  for (std::size_t i = 1; i < times.size(); ++i)
    waits.push_back(times[i] - times[i - 1]);
  return waits;
}

/// Probability that a true sample of that size lies as far from its distribution (Kolmogorov).
double kolmogorov_p(double distance, double count) {
  const double x = distance * (std::sqrt(count) + 0.12 + 0.11 / std::sqrt(count));
  double p = 0;
  for (int k = 1; k < 100; ++k)
    p += (k % 2 ? 2 : -2) * std::exp(-2.0 * k * k * x * x);
  return p;
}

} // namespace

namespace {

void check_counts(std::initializer_list<double> rates) {
  for (const double rate : rates) {
    const double expected = 200 * 60;
    const auto count = static_cast<double>(events(200, rate, 60, 5).size());
    CHECK(std::abs(count - expected) < 3 * std::sqrt(expected));
  }
}

} // namespace

TEST_CASE("events of 200 a second come 12000 times a minute") { check_counts({22050}); }
TEST_CASE("events of 200 a second come 12000 times a minute at any sample rate" *
          doctest::test_suite("slow")) {
  check_counts({44100, 48000, 96000, 192000});
}

TEST_CASE("waiting times are exponential, also where several events fall in one sample") {
  for (const double rate_hz : {200.0, 60000.0}) {
    auto waits = differences(events(rate_hz, 48000, rate_hz > 1000 ? 1 : 60, 3));
    double sum = 0, square = 0;
    for (const double w : waits) {
      sum += w;
      square += w * w;
    }
    const auto count = static_cast<double>(waits.size());
    const double mean = sum / count;
    CHECK(std::sqrt(square / count - mean * mean) / mean == doctest::Approx(1).epsilon(0.05));
    std::sort(waits.begin(), waits.end());
    double distance = 0;
    for (std::size_t i = 0; i < waits.size(); ++i) {
      const double p = 1 - std::exp(-waits[i] * rate_hz);
      distance = std::max({distance, std::abs(p - static_cast<double>(i) / count),
                           std::abs(p - static_cast<double>(i + 1) / count)});
    }
    CHECK(kolmogorov_p(distance, count) > 0.01);
  }
}

TEST_CASE("counts in windows of a changing rate scatter as Poisson's do") {
  PoissonClock clock;
  Random random(2);
  double sum = 0, square = 0;
  const int windows = 20000;
  for (int i = 0; i < windows; ++i) {
    int count = 0;
    for (int n = 0; n < 100; ++n) // integral over the window: 4.95
      count += clock.advance(0.001 * n, random, [](double) {});
    sum += count;
    square += static_cast<double>(count) * count;
  }
  const double mean = sum / windows, variance = square / windows - mean * mean;
  CHECK(mean == doctest::Approx(4.95).epsilon(0.01));      // 3 standard errors
  CHECK(variance == doctest::Approx(4.95).epsilon(0.035)); // 3 standard errors
}

TEST_CASE("event energies follow the power law: its exponent by maximum likelihood, its mean") {
  Random random(8);
  for (const double exponent : {0.5, 1.45, 2.5}) {
    PowerLaw law;
    law.set(exponent, 1e6);
    double logarithms = 0;
    const int count = 100000;
    for (int i = 0; i < count; ++i) {
      const double e = law.draw(random);
      REQUIRE(e >= 1);
      REQUIRE(e <= 1e6);
      logarithms += std::log(e);
    }
    CHECK(count / logarithms == doctest::Approx(exponent).epsilon(0.05));
    // With the upper end nearer the mean is soon measured.
    law.set(exponent, 50);
    double sum = 0;
    for (int i = 0; i < 100000; ++i)
      sum += law.draw(random);
    CHECK(sum / 100000 == doctest::Approx(law.mean()).epsilon(0.02));
  }
}

TEST_CASE("a power law is held within its ranges, and its mean is the integral") {
  const auto mean_of = [](double exponent, double largest) {
    PowerLaw law;
    law.set(exponent, largest);
    return law.mean();
  };
  const auto integral = [](double exponent, double largest) {
    double above = 0, below = 0; // over the logarithm of the energy, by Simpson's rule
    const int count = 20000;
    for (int i = 0; i <= count; ++i) {
      const double e = std::exp(std::log(largest) * i / count);
      const double weight = (i == 0 || i == count ? 1 : i % 2 ? 4 : 2) * std::pow(e, -exponent);
      above += weight * e;
      below += weight;
    }
    return above / below;
  };
  for (const double exponent : {.3, 1., 1.000000001, 1.7, 4.})
    for (const double largest : {1.5, 100., 1e5})
      CHECK(mean_of(exponent, largest) ==
            doctest::Approx(integral(exponent, largest)).epsilon(1e-5));
  CHECK(mean_of(50, 100) == mean_of(20, 100));
  CHECK(mean_of(19, 100) != mean_of(20, 100));
  CHECK(mean_of(-1, 100) == mean_of(.05, 100));
  CHECK(mean_of(.06, 100) != mean_of(.05, 100));
  CHECK(mean_of(1, 0) == mean_of(1, 1.001));
  CHECK(mean_of(1, 1e12) == mean_of(1, 1e9));
  CHECK(mean_of(1, 9e8) != mean_of(1, 1e9));
}
