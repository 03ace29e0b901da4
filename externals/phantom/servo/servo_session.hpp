#pragma once

#include "core/haptic/device/simulated_device.hpp"
#include "core/object.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/servo/servo_rig.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>

namespace tactus::phantom {

/// A servo and its stepping. The host's logical time or a thread of this object steps the servo;
/// for a real device, the thread that the device's worker has started does.
class ServoSession {
public:
  [[nodiscard]] ServoRig& rig() const noexcept { return *rig_; }
  [[nodiscard]] haptic::Exchange& exchange() const noexcept { return rig_->servo.exchange(); }
  /// For the worker, which keeps rig and thread as long as the servo's thread runs.
  [[nodiscard]] const std::shared_ptr<ServoRig>& shared_rig() const noexcept { return rig_; }
  [[nodiscard]] const std::shared_ptr<devices::ServoThread>& thread() const noexcept {
    return thread_;
  }

  double rate_hz = 1000; ///< the rate that the patch requests
  bool wall = false;     ///< true if a thread steps the servo, not the host's logical time
  haptic::Command command{};

  /// Time on the clock that steps the servo.
  [[nodiscard]] double now_s(const Host& host) const noexcept {
    return wall ? devices::ServoThread::now_s() : host.now_ms() * 1e-3;
  }
  /// Passes the command to the servo. The command's time also shows that the host is alive.
  void publish(double now_s) noexcept;
  void step(double now_s, double period_s) noexcept;
  /// Time of the last step, s.
  [[nodiscard]] double stepped_s() const noexcept { return stepped_s_; }

  /// Reads a new report. Returns true if there is one.
  bool read_report() noexcept;
  /// The newest report of the present device; null before the first report.
  [[nodiscard]] const haptic::Report* report() const noexcept {
    return has_report_ ? &exchange().reports.latest() : nullptr;
  }
  void forget_report() noexcept { has_report_ = false; }
  /// Counters and timing of the servo; `threaded` is true if a thread steps it.
  [[nodiscard]] haptic::ServoStatistics statistics(bool threaded) const noexcept;

  void attach(haptic::SimulatedDevice& device) noexcept;
  void attach(const std::shared_ptr<haptic::Backend>& device) noexcept;
  /// Call it so that audio no longer steps or plays the servo.
  void leave_audio() noexcept { rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {}); }

  /// Starts a thread for a simulated device; returns a sentence if the system provides none.
  [[nodiscard]] std::string start() { return thread_->start(rig_->servo, 1 / rate_hz); }
  [[nodiscard]] bool in_thread() const noexcept { return thread_->running(); }
  /// Lets the force fall at the slew limit, for at most 200 ms, and ends the thread.
  void fade_out() noexcept;
  /// Makes a change while the thread does not step.
  template <class Change> void between_ticks(const Change& change) {
    const bool was_running = thread_->running();
    if (was_running)
      static_cast<void>(thread_->stop()); // can wait, because a simulated step cannot hang
    change();
    if (was_running)
      refusal_ = start();
  }
  /// Returns, once, the reason why the thread did not start again.
  [[nodiscard]] std::string take_refusal() noexcept { return std::exchange(refusal_, {}); }

  /// Makes a new servo that continues with the requests and the last report of this one, which then
  /// belongs to the thread that ends it.
  void replace();

private:
  std::shared_ptr<ServoRig> rig_ = std::make_shared<ServoRig>();
  std::shared_ptr<devices::ServoThread> thread_ = std::make_shared<devices::ServoThread>();
  std::string refusal_;
  std::uint64_t index_ = 0; ///< ticks in logical time
  double stepped_s_ = 0;
  bool has_report_ = false;
};

} // namespace tactus::phantom
