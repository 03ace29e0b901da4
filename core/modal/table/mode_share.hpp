#pragma once

#include <cstdint>

namespace tactus::modal {

/// How far a mode of the earlier shape goes on as a mode of the new one: their modal coordinates
/// are z_now = sum over before of share z_before. The shares are a partial isometry, so that no
/// energy arises: +-1 for a mode that keeps its shape, a rotation among modes of like frequency
/// that mix, nothing for a mode that has no successor.
struct ModeShare {
  std::uint32_t before = 0, now = 0; ///< numbers of the modes
  double share = 0;                  ///< -1..1
};

} // namespace tactus::modal
