#pragma once

#include "core/haptic/device/force_timeout.hpp"

namespace tactus::net {

/// The clock used for clients' silence and samples' ages, s.
[[nodiscard]] inline double now_s() noexcept { return haptic::ForceTimeout::now_s(); }

} // namespace tactus::net
