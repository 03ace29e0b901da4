#pragma once

namespace tactus::reed {

/// Samples between two readings of the controls of a reed: f_r, f_b, the player, parameters that
/// glide. Counted from reset(), whatever the host's blocks are.
inline constexpr int kControlPeriod = 32;

} // namespace tactus::reed
