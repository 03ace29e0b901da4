#pragma once

#include <cmath>

namespace tactus::reed {

/// Up to here a sound is left as it is.
inline constexpr double kLinearLimit = 0.5;

/// What keeps a sound outlet within +-1: y = x to 1/2, then sign(x) (1 - 1/(4|x|)), continuous in
/// slope. NaN stays NaN.
[[nodiscard]] inline double soft_clip(double x) noexcept {
  const double size = std::abs(x);
  return size <= kLinearLimit ? x : std::copysign(1 - 0.25 / size, x);
}

} // namespace tactus::reed
