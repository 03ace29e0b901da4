#pragma once

#include "core/haptic/servo/servo.hpp"
#include "core/object.hpp"

#include <string>

namespace tactus::phantom {

/// The settings of the servo, and the messages that set them, which return a sentence when they are
/// refused.
class ServoSetup {
public:
  using Words = std::span<const Atom>;

  /// In the user's units.
  struct Parameters {
    double forcemax_n = 8, slew_n_per_ms = 2, extrap_ms = 0;
    bool strict = false, resume = false, passivity = true;
    double tank_j = 5e-3, allowance_w = haptic::kAllowance_w, damp_n_s_per_m = 0, walls_n_per_m = 0;
  };
  Parameters given{};
  haptic::ServoSettings settings{};

  [[nodiscard]] std::string set_workspace(Words words, const haptic::Caps& caps,
                                          const Vec3* position, Host& host);
  [[nodiscard]] std::string set_map(Words words);
  [[nodiscard]] std::string set_interpolation(Words words);
  [[nodiscard]] std::string set_watchdog(Words words);
  /// `workspace learn 1`: includes a position. True when the workspace has changed.
  [[nodiscard]] bool learn(const Vec3& position) noexcept;
  /// A device has been opened: its workspace, unless the user has set one.
  void use_workspace(const haptic::Caps& caps) noexcept;
  /// The servo's settings for a device. `resumes`: whose force returns after a freeze of the host
  /// in any case.
  [[nodiscard]] const haptic::ServoSettings& update(const haptic::Caps& caps,
                                                    bool resumes) noexcept;
  void send_workspace(Host& host) const;
  void dump(Host& host) const;

private:
  bool learning_ = false, own_workspace_ = false;
};

} // namespace tactus::phantom
