#pragma once

#include "core/haptic/servo/servo.hpp"
#include "externals/phantom/reports.hpp"

#include <string_view>

namespace tactus::phantom {

/// Reports how the force chain changes the force, so that the user knows why the force felt differs
/// from the patch's request.
class ChainWatch {
public:
  /// Clipping is logged once, warm motors each time. True when the host has frozen.
  [[nodiscard]] bool watch(const haptic::Report& report, double force_limit_n,
                           std::string_view device, const Reports& reports, Host& host);

private:
  bool warm_ = false, clipping_ = false, braking_ = false, frozen_ = false;
  bool clipping_logged_ = false;
};

} // namespace tactus::phantom
