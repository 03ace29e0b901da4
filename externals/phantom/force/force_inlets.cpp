#include "externals/phantom/force/force_inlets.hpp"

#include <cmath>

namespace tactus::phantom {

void ForceInlets::set(std::size_t inlet, double value) noexcept {
  if (std::isfinite(value)) {
    values_[static_cast<int>(inlet)] = value;
    changed_ = true;
  } else {
    refused_ = true;
  }
}

void ForceInlets::apply(double limit_n, Host& host) {
  haptic::Command& command = session_.command;
  if (refused_) {
    ++command.refused;
    command.last_refused = true;
    if (host.now_ms() - last_error_ms_ >= 1000) {
      last_error_ms_ = host.now_ms();
      host.error(
          "force: not a finite number; the last valid force stays until the watchdog ends it");
      reports_.send(kError, {"error", "nan", "force", "refused"}, host);
    }
  } else if (changed_) {
    command.force_n = values_ * (in_shares_of_limit ? limit_n : 1.0);
    ++command.number;
    command.last_refused = false;
  }
  refused_ = changed_ = false;
  session_.publish(session_.now_s(host));
}

} // namespace tactus::phantom
