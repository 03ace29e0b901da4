#include "core/reed/instrument/halfband.hpp"

#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

/// Modified Bessel function I_0 by its power series.
double bessel(double x) {
  double term = 1, sum = 1;
  for (int k = 1; k < 40; ++k) {
    term *= (x / (2 * k)) * (x / (2 * k));
    sum += term;
  }
  return sum;
}

} // namespace

template <int pairs> std::array<double, pairs> halfband_coefficients() noexcept {
  constexpr double kBeta = 7; // Kaiser: about -70 dB
  std::array<double, pairs> h{};
  double sum = 0;
  for (int j = 0; j < pairs; ++j) {
    const double n = 2 * j + 1, position = n / (2 * pairs);
    const double sinc = (j % 2 == 0 ? 1 : -1) / (std::numbers::pi * n);
    h[static_cast<std::size_t>(j)] = sinc * bessel(kBeta * std::sqrt(1 - position * position));
    sum += 2 * h[static_cast<std::size_t>(j)];
  }
  for (double& value : h)
    value *= 0.5 / sum;
  return h;
}

template std::array<double, 4> halfband_coefficients<4>() noexcept;
template std::array<double, 8> halfband_coefficients<8>() noexcept;

} // namespace tactus::reed
