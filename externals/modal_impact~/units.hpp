#pragma once

#include <array>
#include <string_view>

namespace tactus::modal_impact {

inline constexpr double kMillimetre = 0.001; ///< m, the unit of positions in messages
inline constexpr double kFarthest = 1e6;     ///< mm, the largest coordinate of a position
/// The words of modal::Radiation, in its order.
inline constexpr std::array<std::string_view, 4> kRadiations{"modal", "raw", "body", "none"};
/// With `limit auto`: at this gain or above the output serves measurements and is not limited.
inline constexpr double kMeasuringGain = 0.1;

} // namespace tactus::modal_impact
