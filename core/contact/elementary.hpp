#pragma once

#include <bit>
#include <cmath>
#include <cstdint>
#include <numbers>

/// Powers, exponentials and logarithms from + - * / and square roots only. The results are
/// bit-identical on every platform, because no call goes to the platform's mathematical library.
/// All functions are always inline, because source files compiled for newer instruction sets use
/// them too and must not emit a shared copy.
namespace tactus::contact {

/// x clamped to [-limit, limit]; 0 for NaN.
[[nodiscard, gnu::always_inline]] inline double bounded(double x, double limit) noexcept {
  return x > limit ? limit : (x < -limit ? -limit : (x == x ? x : 0));
}
/// x clamped to [low, high]; `fallback` for NaN and infinities.
[[nodiscard, gnu::always_inline]] inline double within(double x, double low, double high,
                                                       double fallback) noexcept {
  return std::isfinite(x) ? (x < low ? low : (x > high ? high : x)) : fallback;
}

/// 2^y with a relative error below 1e-12. y is clamped to [-1000, 1000].
[[nodiscard, gnu::always_inline]] inline double exp2_of(double y) noexcept {
  y = y < -1000 ? -1000 : (y > 1000 ? 1000 : y);
  // Adding kRound leaves the integer nearest to y in the last bits of the mantissa; the shift
  // below moves it to the exponent.
  constexpr double kRound = 0x1.8p52;
  const double shifted = y + kRound, t = y - (shifted - kRound); // |t| <= 1/2
  const double scale = std::bit_cast<double>((std::bit_cast<std::uint64_t>(shifted) << 52) +
                                             std::bit_cast<std::uint64_t>(1.0));
  // Taylor's series to t^10: ln(2)^k/k!.
  const double t2 = t * t, t4 = t2 * t2, t8 = t4 * t4;
  const double a =
      (1 + t * 6.9314718055994531e-1) + t2 * (2.4022650695910072e-1 + t * 5.5504108664821580e-2);
  const double b = (9.6181291076284772e-3 + t * 1.3333558146428443e-3) +
                   t2 * (1.5403530393381609e-4 + t * 1.5252733804059840e-5);
  const double c = (1.3215486790144309e-6 + t * 1.0178086009239699e-7) + t2 * 7.0549116208011233e-9;
  return scale * ((a + t4 * b) + t8 * c);
}

/// log2 x for a normal number x > 0, absolute error below 1e-14.
[[nodiscard, gnu::always_inline]] inline double log2_of(double x) noexcept {
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

/// x^e for one exponent e >= 0 and many x.
class Power {
public:
  explicit Power(double exponent = 0) noexcept : exponent_(exponent) {
    const double quarters = 4 * exponent;
    if (quarters <= 5 && quarters == std::floor(quarters))
      quarters_ = static_cast<int>(quarters);
  }
  /// x^e for x > 0. Hertz' contact and other common ones have a multiple of 1/4 as exponent, which
  /// takes only square roots.
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
      return exp2_of(exponent_ * log2_of(x));
    }
  }
  [[nodiscard]] double exponent() const noexcept { return exponent_; }

private:
  double exponent_;
  int quarters_ = -1;
};

/// x^e for an x that changes little from call to call. While x stays within 1/16 of the anchor (the
/// x of the last full evaluation) six terms of the binomial series about the anchor are used.
/// Relative error below 1e-9 for 0 <= e <= 5/2.
class TaylorPower {
public:
  explicit TaylorPower(double exponent = 0) noexcept : power_(exponent) {
    double factor = 1;
    for (int k = 0; k < kTerms; ++k)
      term_[k] = factor *= (exponent - k) / (k + 1);
  }
  /// x^e for x > 0.
  [[nodiscard, gnu::always_inline]] double operator()(double x) noexcept {
    if (power_.exponent() == 0)
      return 1;
    const double d = x * inverse_ - 1;
    if (!(std::abs(d) < kReach)) {
      value_ = power_(x);
      inverse_ = 1 / x;
      return value_;
    }
    const double d2 = d * d;
    return value_ * (((1 + term_[0] * d) + d2 * (term_[1] + term_[2] * d)) +
                     (d2 * d2) * ((term_[3] + term_[4] * d) + term_[5] * d2));
  }

  static constexpr int kTerms = 6;
  static constexpr double kReach = 0.0625; ///< the series is used for |x/anchor - 1| below this
  /// x^e and 1/x at the last full evaluation.
  struct Anchor {
    double value = 0, inverse = 0;
  };
  [[nodiscard]] Anchor anchor() const noexcept { return {value_, inverse_}; }
  void set_anchor(const Anchor& anchor) noexcept {
    value_ = anchor.value;
    inverse_ = anchor.inverse;
  }
  [[nodiscard]] double exponent() const noexcept { return power_.exponent(); }
  [[nodiscard]] double term(int k) const noexcept { return term_[k]; }

private:
  Power power_;
  double value_ = 0, inverse_ = 0;
  double term_[kTerms];
};

} // namespace tactus::contact
