#pragma once

#include "core/dsp/elementary.hpp"

namespace tactus::math {

/// A complex number. std::complex leaves quotients and roots to the compiler's and the C library,
/// which differ in the last bits; here they are as portable as math's functions. Products do not
/// look for infinities that have become NaN (C's annex G).
class Complex {
public:
  constexpr Complex(double real = 0, double imag = 0) noexcept : real_(real), imag_(imag) {}
  [[nodiscard]] constexpr double real() const noexcept { return real_; }
  [[nodiscard]] constexpr double imag() const noexcept { return imag_; }

  friend constexpr Complex operator+(Complex a, Complex b) noexcept {
    return {a.real_ + b.real_, a.imag_ + b.imag_};
  }
  friend constexpr Complex operator-(Complex a, Complex b) noexcept {
    return {a.real_ - b.real_, a.imag_ - b.imag_};
  }
  friend constexpr Complex operator-(Complex a) noexcept { return {-a.real_, -a.imag_}; }
  friend constexpr Complex operator*(Complex a, Complex b) noexcept {
    return {a.real_ * b.real_ - a.imag_ * b.imag_, a.real_ * b.imag_ + a.imag_ * b.real_};
  }
  friend constexpr Complex operator*(Complex a, double b) noexcept {
    return {a.real_ * b, a.imag_ * b};
  }
  friend constexpr Complex operator*(double a, Complex b) noexcept { return b * a; }
  friend constexpr Complex operator/(Complex a, double b) noexcept {
    return {a.real_ / b, a.imag_ / b};
  }
  /// Infinite for b = 0, and 0 for an infinite b.
  friend constexpr Complex operator/(Complex a, Complex b) noexcept {
    double size = b.real_ * b.real_ + b.imag_ * b.imag_;
    if (!(size > 0x1p-900 && size < 0x1p900)) {
      if (b == Complex(0))
        return {a.real_ / b.real_, a.imag_ / b.real_};
      if (b.is_infinite())
        return 0;
      const double scale = size > 1 ? 0x1p-600 : 0x1p600; // without error
      a *= scale;
      b *= scale;
      size = b.real_ * b.real_ + b.imag_ * b.imag_;
    }
    return {(a.real_ * b.real_ + a.imag_ * b.imag_) / size,
            (a.imag_ * b.real_ - a.real_ * b.imag_) / size};
  }
  constexpr Complex& operator+=(Complex b) noexcept { return *this = *this + b; }
  constexpr Complex& operator-=(Complex b) noexcept { return *this = *this - b; }
  constexpr Complex& operator*=(Complex b) noexcept { return *this = *this * b; }
  constexpr Complex& operator*=(double b) noexcept { return *this = *this * b; }
  constexpr Complex& operator/=(Complex b) noexcept { return *this = *this / b; }
  constexpr Complex& operator/=(double b) noexcept { return *this = *this / b; }
  friend constexpr bool operator==(Complex, Complex) noexcept = default;

private:
  [[nodiscard]] constexpr bool is_infinite() const noexcept {
    constexpr double kMax = 0x1.fffffffffffffp1023;
    return real_ > kMax || real_ < -kMax || imag_ > kMax || imag_ < -kMax;
  }
  double real_, imag_;
};

[[nodiscard]] constexpr Complex conj(Complex z) noexcept { return {z.real(), -z.imag()}; }
/// |z|^2
[[nodiscard]] constexpr double norm(Complex z) noexcept {
  return z.real() * z.real() + z.imag() * z.imag();
}
[[nodiscard]] inline double abs(Complex z) noexcept { return hypot(z.real(), z.imag()); }
[[nodiscard]] inline double arg(Complex z) noexcept { return atan2(z.imag(), z.real()); }
[[nodiscard]] inline Complex polar(double size, double angle) noexcept {
  const SineCosine of = sincos(angle);
  return {size * of.cosine, size * of.sine};
}
[[nodiscard]] inline Complex exp(Complex z) noexcept { return polar(exp(z.real()), z.imag()); }
/// The root with a real part that is not negative.
[[nodiscard]] Complex sqrt(Complex z) noexcept;

} // namespace tactus::math

namespace tactus {
using math::Complex;
}
