#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "core/object.hpp"

#include <functional>
#include <string>
#include <utility>

namespace tactus::phantom {

/// The simulated device, and the messages to it and to the hand that holds it. They return a
/// sentence when they are refused.
class Simulation {
public:
  using Words = std::span<const Atom>;
  using Change = std::function<void(haptic::SimulatedDevice&)>;

  /// `between_ticks`: makes a change while nobody steps the device.
  explicit Simulation(std::function<void(const Change&)> between_ticks)
      : between_ticks_(std::move(between_ticks)) {}

  /// In the user's units.
  struct Parameters {
    double mass_kg = 0.1, viscous_n_s_per_m = 0.5;
    bool stops = true;
    double resolution_mm = 0, noise_mm = 0, latency_ticks = 0;
    unsigned seed = 1;
  };
  Parameters given{};
  haptic::SimulatedDevice device{};

  /// Sets the device to the parameters and the hand; `changed` is called if its capabilities have
  /// changed.
  void apply(const std::function<void()>& changed);

  /// Sets the hand, until apply().
  [[nodiscard]] std::string hold(Words words);
  [[nodiscard]] std::string set_path(Words words, const Host& host);
  [[nodiscard]] std::string set_target(Words words);
  [[nodiscard]] std::string seek(Words words);
  [[nodiscard]] std::string press(Words words);
  void dump(Host& host) const;

private:
  std::function<void(const Change&)> between_ticks_;
  haptic::HandSettings hand_{};
  std::string path_name_ = "still";
};

} // namespace tactus::phantom
