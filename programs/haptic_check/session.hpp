#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "core/haptic/scene/scene_model.hpp"
#include "core/haptic/servo/servo.hpp"
#include "devices/servo_thread.hpp"
#include "programs/haptic_check/analysis.hpp"
#include "programs/haptic_check/options.hpp"

#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::haptic_check {

/// Sines along x, one after the other, each rising and falling within a twentieth of a second.
class Sines final : public haptic::LocalModel {
public:
  static constexpr double kFade_s = 0.05;
  struct Part {
    double frequency_hz = 0, amplitude_n = 0, from_s = 0, to_s = 0;
  };
  /// Sets the sines; call it while no servo runs.
  void play(std::vector<Part> parts) { parts_ = std::move(parts); }
  [[nodiscard]] Vec3 force(const haptic::Tick& tick, const haptic::State& state) noexcept override;

private:
  std::vector<Part> parts_;
};

/// The recording of one station.
struct Recording {
  std::vector<Record> records;
  std::size_t hits = 0;
  haptic::ServoStatistics statistics{};
  haptic::ChainCounters counters{};
  double lowest_energy_j = 0;
  std::string scheduling;
  std::string trouble;    ///< the device's last fault
  bool latched = false;   ///< the motors stopped because of a fault
  std::uint64_t lost = 0; ///< ticks that were not recorded, because the ring was full
};

/// A device with its servo. Every station starts with the motors off and ends with no force.
class Session {
public:
  /// A driver's device, or the simulated one with a simulated hand.
  explicit Session(std::unique_ptr<haptic::Backend> device, haptic::SimulatedDevice* simulated)
      : device_(std::move(device)), simulated_(simulated) {}
  ~Session();

  /// Opens the device in a separate thread, printing dots. Returns an empty text, or what to do.
  [[nodiscard]] std::string open();
  [[nodiscard]] haptic::Backend& device() noexcept { return *device_; }
  /// Null for a real device.
  [[nodiscard]] haptic::SimulatedDevice* simulated() noexcept { return simulated_; }

  struct Plan {
    double seconds = 8, period_s = 1e-3, force_limit_n = 1;
    bool motors = false;
    haptic::Scene scene{};
    std::vector<Sines::Part> sines{};
    std::function<std::string(const haptic::Report&)> line{}; ///< text to show while it runs
    std::function<bool(const haptic::Report&)> done{};        ///< ends the station early if true
  };
  /// Runs the servo for that time. `error` is empty unless the device's own thread did not start.
  [[nodiscard]] Recording run(const Plan& plan, std::string& error);

private:
  void fade_out() noexcept;
  void send_heartbeat() noexcept;
  void drain(Recording& recording);
  /// Records while the servo runs, until the plan's time is over or its done() returns true.
  void record(const Plan& plan, Recording& recording);

  std::unique_ptr<haptic::Backend> device_;
  haptic::SimulatedDevice* simulated_;
  haptic::Servo servo_;
  haptic::SceneModel scene_;
  Sines sines_;
  devices::ServoThread thread_;
};

} // namespace tactus::haptic_check
