#include "core/reed/bore/open_end.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/radiation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

/// b_0 + b_1 x + b_2 x^2 over (1 - p_1 x)(1 - p_2 x), x = z^-1.
DigitalOpenEnd from_coefficients(double b0, double b1, double b2, double p1, double p2) {
  const double c2 = b1 + b0 * (p1 + p2);
  return {{p1, p2}, {b2 - b0 * p1 * p2 + c2 * p1, c2}, b0};
}

bool passive(const DigitalOpenEnd& end) {
  constexpr int kPoints = 64; // points up to the Nyquist frequency
  for (int i = 1; i <= kPoints; ++i)
    if (math::abs(end.at(math::polar(1.0, -std::numbers::pi * i / kPoints))) > 1)
      return false;
  return true;
}

/// The bilinear transform s = 2/T (1 - x)/(1 + x), passive at any radius.
DigitalOpenEnd bilinear(double radius) {
  const double zero = 2 * radius * OpenEnd::kNumerator;
  const double first = 2 * radius / OpenEnd::kFirstPole;
  const double second = 2 * radius / OpenEnd::kSecondPole;
  const double scale = -1 / ((1 + first) * (1 + second));
  return from_coefficients(scale * (1 + zero), scale * 2, scale * (1 - zero),
                           (first - 1) / (first + 1), (second - 1) / (second + 1));
}

} // namespace

DigitalOpenEnd DigitalOpenEnd::of(double radius, double period) noexcept {
  constexpr double kHighest = 12e3; // Hz
  const double p1 = math::exp(-OpenEnd::kFirstPole / radius);
  const double p2 = math::exp(-OpenEnd::kSecondPole / radius);
  // R(x) = B(x)/A(x), B = B(1) + B'(1) (x - 1) + t (x - 1)^2. R(0 Hz) = -1 gives B(1) = -A(1), the
  // delay of long waves B'(1) = -(A(1) delay + A'(1)); t is fitted.
  const double dc_denominator = (1 - p1) * (1 - p2), slope = 2 * p1 * p2 - p1 - p2;
  const double delay = (OpenEnd::kFirst - OpenEnd::kNumerator) * radius; // samples
  const double rise = -(dc_denominator * delay + slope);
  double projection = 0, norm_squared = 0;
  for (int i = 1; i <= 8; ++i) {
    const double omega =
        std::min(2 * std::numbers::pi * kHighest * period, 0.9 * std::numbers::pi) * i / 8;
    const Complex x = math::polar(1.0, -omega), x_minus_one = x - 1.0;
    const Complex denominator = (1.0 - p1 * x) * (1.0 - p2 * x);
    const Complex residual = OpenEnd::reflection({0, omega * radius}) -
                             (-dc_denominator + rise * x_minus_one) / denominator;
    const Complex shape = x_minus_one * x_minus_one / denominator;
    projection += (math::conj(shape) * residual).real();
    norm_squared += math::norm(shape);
  }
  const double t = projection / norm_squared;
  const DigitalOpenEnd end = from_coefficients(-dc_denominator - rise + t, rise - 2 * t, t, p1, p2);
  return passive(end) ? end : bilinear(radius);
}

} // namespace tactus::reed
