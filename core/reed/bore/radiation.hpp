#pragma once

#include "core/dsp/complex.hpp"

namespace tactus::reed {

/// Reflectance of plane waves at an unflanged open end of radius r_e: a passive second-order fit of
/// Levine and Schwinger's exact solution (Silva, Guillemain, Kergomard, Mallaroni & Norris 2009),
///   R = -(1 + n j)/(1 + d_1 j + d_2 j^2),   j = s r_e/c.
/// For long waves the length correction is 0.613 r_e and |R| = 1 - (k r_e)^2/2. Valid to about
/// k r_e = 2.
struct OpenEnd {
  static constexpr double kNumerator = 0.167, kFirst = 1.393, kSecond = 0.457;
  static constexpr double kLengthCorrection = 0.613;
  // d_2 j^2 + d_1 j + 1 = (1 + j/k_1)(1 + j/k_2): both poles are real.
  static constexpr double kFirstPole = 1.1571836305301262, kSecondPole = 1.89095641323355;

  [[nodiscard]] static Complex reflection(Complex j) noexcept {
    return -(1.0 + kNumerator * j) / (1.0 + j * (kFirst + kSecond * j));
  }
};

} // namespace tactus::reed
