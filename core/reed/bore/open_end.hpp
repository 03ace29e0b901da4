#pragma once

#include "core/dsp/complex.hpp"

#include <array>

namespace tactus::reed {

/// Digital filter for the reflection at an open end (OpenEnd): two real poles in cascade,
///   first' = p_1 first + c_1 in,   second' = p_2 second + c_2 in + first,   out = d in + second.
/// The poles are exact, exp(-k c T/r_e). Two of the three other coefficients make R(0) = -1 and the
/// delay of long waves exact; the third is fitted to R up to 12 kHz (least squares). If the fit
/// would exceed |R| = 1, the bilinear transform of OpenEnd is taken instead.
struct DigitalOpenEnd {
  std::array<double, 2> pole{}, input{}; // p_1, p_2 and c_1, c_2
  double direct = -1;                    // d

  /// radius: r_e/(c T), the radius in samples of sound travel; period: T, s.
  [[nodiscard]] static DigitalOpenEnd of(double radius, double period) noexcept;
  /// Response at back = z^-1.
  [[nodiscard]] Complex at(Complex back) const noexcept {
    const Complex first = input[0] * back / (1.0 - pole[0] * back);
    return direct + back * (input[1] + first) / (1.0 - pole[1] * back);
  }
};

} // namespace tactus::reed
