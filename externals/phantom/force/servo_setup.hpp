#pragma once

#include "externals/phantom/device/device_link.hpp"
#include "externals/phantom/words.hpp"

#include <string>

namespace tactus::phantom {

/// The settings of the servo and its force chain, and the messages that set them.
class ServoSetup {
public:
  ServoSetup(ServoSession& session, const DeviceLink& link) : session_(session), link_(link) {}

  /// Parameters in the user's units.
  struct Parameters {
    double forcemax_n = 8, slew_n_per_ms = 2, extrap_ms = 0;
    bool strict = false, resume = false, passivity = true;
    double tank_j = 5e-3, allowance_w = haptic::kAllowance_w, damp_n_s_per_m = 0, walls_n_per_m = 0;
  };
  Parameters given{};

  [[nodiscard]] const haptic::Workspace& workspace() const noexcept {
    return settings_.chain.workspace;
  }
  /// The smaller of forcemax and the device's peak force.
  [[nodiscard]] double force_limit_n() const noexcept { return settings_.chain.force_limit_n; }
  /// Passes the settings for the present device to the servo.
  void apply() noexcept;

  void set_workspace(Words words, Host& host);
  void set_map(Words words, Host& host);
  void set_interpolation(const Atom& time, Host& host);
  void set_watchdog(Words words, Host& host);
  /// With `workspace learn 1`, extends the workspace to include the handle's position.
  void learn() noexcept;
  /// Takes the workspace of a newly opened device, unless the user has set one.
  void use_workspace() noexcept;
  void dump(Host& host) const;

private:
  [[nodiscard]] std::string change_workspace(Words words, Host& host);
  void write() noexcept;
  void send_workspace(Host& host) const;

  ServoSession& session_;
  const DeviceLink& link_;
  haptic::ServoSettings settings_{};
  bool learning_ = false, own_workspace_ = false;
};

} // namespace tactus::phantom
