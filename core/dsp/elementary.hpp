#pragma once

/// Elementary functions from + - * /, square roots and operations on bits. Every IEEE machine gives
/// the same bits, which the C libraries of two systems do not. The core uses these in place of
/// <cmath>'s; of that header it uses only what IEEE 754 rounds exactly (sqrt, floor, fmod, ...).
///
/// Each function states its largest error in ulp, units of the result's last place, over its whole
/// range, subnormal numbers and huge arguments included (elementary_test.cpp). Signed zeros,
/// infinities and NaN are treated as by C's annex F. Rounding is to nearest.
///
/// Methods: a table and a short polynomial for exponentials and logarithms (Tang 1989, 1990), three
/// parts of pi/2 for sine and cosine (Cody & Waite 1980) or, where these are too few, the digits of
/// 2/pi (Payne & Hanek 1983), and sums of two doubles where one is too short (Dekker 1971). The
/// compiler computes the tables.
namespace tactus::math {

// Exponentials: 0.52 ulp, and 0.76 where the result is subnormal or nearly so.
[[nodiscard]] double exp(double x) noexcept;
[[nodiscard]] double exp2(double x) noexcept;
[[nodiscard]] double exp10(double x) noexcept;
[[nodiscard]] double expm1(double x) noexcept; ///< e^x - 1; 0.7 ulp

[[nodiscard]] double log(double x) noexcept;   ///< 0.52 ulp
[[nodiscard]] double log2(double x) noexcept;  ///< 0.51 ulp
[[nodiscard]] double log10(double x) noexcept; ///< 0.51 ulp
[[nodiscard]] double log1p(double x) noexcept; ///< log(1 + x); 0.67 ulp

/// x^y; 0.53 ulp, and 0.76 where the result is subnormal or nearly so.
[[nodiscard]] double pow(double x, double y) noexcept;
[[nodiscard]] double cbrt(double x) noexcept; ///< 0.67 ulp
/// sqrt(x^2 + y^2), without overflow on the way; 1.01 ulp.
[[nodiscard]] double hypot(double x, double y) noexcept;

struct SineCosine {
  double sine, cosine;
};
/// Both, of any finite x: 0.8 ulp.
[[nodiscard]] SineCosine sincos(double x) noexcept;
[[nodiscard]] double sin(double x) noexcept;  ///< as sincos
[[nodiscard]] double cos(double x) noexcept;  ///< as sincos
[[nodiscard]] double tan(double x) noexcept;  ///< 1 ulp
[[nodiscard]] double atan(double x) noexcept; ///< 0.9 ulp
/// The angle of the point (x, y), in -pi .. pi; 1.45 ulp.
[[nodiscard]] double atan2(double y, double x) noexcept;

[[nodiscard]] double cosh(double x) noexcept; ///< 1.1 ulp
[[nodiscard]] double tanh(double x) noexcept; ///< 1.4 ulp
/// The gamma function of x > 0, NaN for x < 0; 0.54 ulp.
[[nodiscard]] double tgamma(double x) noexcept;
/// The modified Bessel function I0, by its power series, for |x| < 700; 1e-15 of the result.
[[nodiscard]] double bessel_i0(double x) noexcept;

} // namespace tactus::math
