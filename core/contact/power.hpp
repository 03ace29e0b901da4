#pragma once

#include "core/dsp/elementary.hpp"

#include <cmath>

/// Powers of many numbers with the same exponent, and ranges. Everything is always inline: source
/// files compiled for newer instruction sets use it too, and must not emit a shared copy.
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
      return math::pow(x, exponent_);
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
