#pragma once

#include <cmath>

namespace tactus {

/// |x| up to which soft_clip() is the identity.
inline constexpr double kLinearLimit = 0.5;

/// Soft clipping of a sound output to +-1: y = x for |x| <= 1/2, else sign(x) (1 - 1/(4|x|)). The
/// slope is continuous. NaN stays NaN.
[[nodiscard]] inline double soft_clip(double x) noexcept {
  const double size = std::abs(x);
  return size <= kLinearLimit ? x : std::copysign(1 - 0.25 / size, x);
}

} // namespace tactus
