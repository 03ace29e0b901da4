#pragma once

#include "externals/phantom/device/device_link.hpp"
#include "externals/phantom/words.hpp"

#include <string>
#include <string_view>

namespace tactus::phantom {

/// Messages to the simulated device and to the hand that holds it.
class Simulation {
public:
  Simulation(ServoSession& session, DeviceLink& link) : session_(session), link_(link) {}

  /// Parameters in the user's units.
  struct Parameters {
    double mass_kg = 0.1, viscous_n_s_per_m = 0.5;
    bool stops = true;
    double resolution_mm = 0, noise_mm = 0, latency_ticks = 0;
    unsigned seed = 1;
  };
  Parameters given{};

  /// Applies the parameters and the hand to the device. Restarts the thread that steps the device,
  /// at the present rate.
  void apply();
  /// Handles a message with one of the functions below. They return a sentence if they refuse it.
  template <auto function> void run(const Message& row, Words words, Host& host) {
    const std::string refusal =
        link_.is_real() ? only_simulated(row.name) : (this->*function)(words, host);
    if (!refusal.empty())
      host.error(refusal);
  }
  [[nodiscard]] std::string set_hand(Words words, const Host& host);
  [[nodiscard]] std::string set_path(Words words, const Host& host);
  [[nodiscard]] std::string set_target(Words words, const Host& host);
  [[nodiscard]] std::string seek(Words words, const Host& host);
  [[nodiscard]] std::string press(Words words, const Host& host);
  void dump(Host& host) const;

private:
  [[nodiscard]] std::string only_simulated(std::string_view message) const;
  template <class Change> void between_ticks(const Change& change);

  ServoSession& session_;
  DeviceLink& link_;
  haptic::HandSettings hand_{};
  std::string path_name_ = "still";
};

} // namespace tactus::phantom
