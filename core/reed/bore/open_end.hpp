#pragma once

#include <array>
#include <complex>

namespace tactus::reed {

/// OpenEnd's reflection of one radius at one sample rate: two real poles, the first feeding the
/// second,
///   first' = p_1 first + c_1 in,   second' = p_2 second + c_2 in + first,   out = d in + second.
/// The poles are those of the open end, exp(-k c T/r_e); the three coefficients make R(0) = -1, the
/// delay of long waves exact, and the rest of the curve to 12 kHz as near as one number can (least
/// squares). |R| <= 1 at every frequency.
struct DigitalOpenEnd {
  std::array<double, 2> pole{}, input{}; // p_1, p_2 and c_1, c_2
  double direct = -1;                    // d

  /// radius is r_e/(c T), the end's radius in samples of sound's way; period T in s.
  [[nodiscard]] static DigitalOpenEnd of(double radius, double period) noexcept;
  /// At exp(i 2 pi f/rate) = 1/back.
  [[nodiscard]] std::complex<double> at(std::complex<double> back) const noexcept {
    const std::complex<double> first = input[0] * back / (1.0 - pole[0] * back);
    return direct + back * (input[1] + first) / (1.0 - pole[1] * back);
  }
};

} // namespace tactus::reed
