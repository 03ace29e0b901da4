#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/gradient_plane.hpp"

namespace tactus::reed {

/// The range of mouth pressure and reed frequency in which an instrument plays. Blown closed: up to
/// 1.25 times the closing pressure, 0.4 to 1.4 times the reed frequency. Others: up to 5.6 times
/// the lowest threshold, 0.25 to 2.75 times their frequency, so that lips find several registers.
/// Pressures are rounded to 100 Pa. Takes some milliseconds.
[[nodiscard]] ControlRange range_for(const Parameters& parameters) noexcept;

} // namespace tactus::reed
