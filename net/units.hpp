#pragma once

namespace tactus::net {

/// Positions are metres inside and millimetres in messages.
inline constexpr double kM_per_mm = 1e-3;
inline constexpr double kMm_per_m = 1e3;

} // namespace tactus::net
