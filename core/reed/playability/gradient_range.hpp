#pragma once

#include "core/reed/instrument/parameters.hpp"
#include "core/reed/playability/gradient_plane.hpp"

namespace tactus::reed {

/// A plane in which an instrument's notes lie. Blown closed: up to 1.25 times the pressure that
/// shuts the reed, and from 0.4 to 1.4 of its own frequency. Others: up to 5.6 times the threshold
/// of the mode that starts first, from a quarter to 2.75 times their own frequency, so that lips
/// find several registers. Pressures are rounded to 100 Pa. Takes some milliseconds.
[[nodiscard]] ControlRange range_for(const Parameters& parameters) noexcept;

} // namespace tactus::reed
