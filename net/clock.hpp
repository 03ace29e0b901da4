#pragma once

#include "core/haptic/device/force_timeout.hpp"

namespace tactus::net {

/// Time of the clock by which silence of clients and ages of samples are measured, s.
[[nodiscard]] inline double now_s() noexcept { return haptic::ForceTimeout::now_s(); }

} // namespace tactus::net
