#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

/// Powers and exponentials of + - * / and square roots alone: the same bits on every platform,
/// whatever its mathematical library, and quick enough for every step of a contact. Always inline,
/// since files compiled for newer processors use them too.
namespace tactus::contact {

/// 2^y for |y| <= 1000, relative error below 1e-14; beyond, the value there.
[[nodiscard, gnu::always_inline]] inline double power_of_two(double y) noexcept {
  y = y < -1000 ? -1000 : (y > 1000 ? 1000 : y);
  constexpr double kRound = 0x1.8p52; // its sum with |y| < 2^51 has y's nearest integer at the end
  const double whole = (y + kRound) - kRound;
  const double t = (y - whole) * std::numbers::ln2; // |t| <= 0.347: Taylor's series to t^12
  const double t2 = t * t, t4 = t2 * t2;
  const double low = (1 + t) + t2 * (1.0 / 2 + t * (1.0 / 6));
  const double middle = (1.0 / 24 + t * (1.0 / 120)) + t2 * (1.0 / 720 + t * (1.0 / 5040));
  const double high = (1.0 / 40320 + t * (1.0 / 362880)) +
                      t2 * (1.0 / 3628800 + t * (1.0 / 39916800) + t2 * (1.0 / 479001600));
  const auto exponent = static_cast<std::int64_t>(whole);
  const double scale = std::bit_cast<double>((exponent + 1023) << 52);
  return scale * (low + t4 * (middle + t4 * high));
}

/// log2 x for a normal number x > 0, absolute error below 1e-14.
[[nodiscard, gnu::always_inline]] inline double logarithm_of_two(double x) noexcept {
  // x = 2^k m with m in [sqrt(1/2), sqrt(2)); ln m = 2 artanh(s), s = (m - 1)/(m + 1).
  constexpr std::int64_t kHalfRoot = 0x3fe6a09e667f3bcd; // bits of sqrt(1/2)
  const auto bits = std::bit_cast<std::int64_t>(x);
  const std::int64_t k = (bits - kHalfRoot) >> 52;
  const double m = std::bit_cast<double>(bits - (k << 52));
  const double s = (m - 1) / (m + 1), z = s * s, z2 = z * z, z4 = z2 * z2; // |s| <= 0.172
  const double low = (1 + z * (1.0 / 3)) + z2 * (1.0 / 5 + z * (1.0 / 7));
  const double high =
      (1.0 / 9 + z * (1.0 / 11)) + z2 * (1.0 / 13 + z * (1.0 / 15)) + z4 * (1.0 / 17);
  return static_cast<double>(k) + 2 * std::numbers::log2e * s * (low + z4 * high);
}

/// e^x for x <= 0, relative error below 1e-13 of 1.
[[nodiscard, gnu::always_inline]] inline double decayed(double x) noexcept {
  return power_of_two(std::numbers::log2e * x);
}

/// x^e for one exponent e >= 0 and many x.
class Power {
public:
  explicit Power(double exponent = 0) noexcept : exponent_(exponent) {
    const double quarters = 4 * exponent;
    if (quarters <= 5 && quarters == std::floor(quarters))
      quarters_ = static_cast<int>(quarters);
  }
  /// Of x > 0. The quarter powers, which Hertz' and other common contacts have, by roots.
  [[nodiscard, gnu::always_inline]] double operator()(double x) const noexcept {
    switch (quarters_) {
    case 0:
      return 1;
    case 1:
      return std::sqrt(std::sqrt(x));
    case 2:
      return std::sqrt(x);
    case 3: {
      const double root = std::sqrt(x);
      return root * std::sqrt(root);
    }
    case 4:
      return x;
    case 5:
      return x * std::sqrt(std::sqrt(x));
    default:
      return power_of_two(exponent_ * logarithm_of_two(x));
    }
  }
  [[nodiscard]] double exponent() const noexcept { return exponent_; }

private:
  double exponent_;
  int quarters_ = -1;
};

} // namespace tactus::contact
