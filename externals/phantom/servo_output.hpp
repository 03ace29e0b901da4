#pragma once

#include "core/haptic/device/workspace.hpp"
#include "core/haptic/servo/clock_map.hpp"
#include "externals/phantom/felt_models.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/servo_rig.hpp"
#include "externals/phantom/trace.hpp"

#include <cstdint>
#include <optional>
#include <string>

namespace tactus::phantom {

/// What the patch gets to know of the servo: positions, events, statistics and the trace.
class ServoOutput {
public:
  explicit ServoOutput(const Reports& reports) : reports_(reports) {}

  /// Reads the servo's reports and writes the trace. `wall`: the servo runs on the wall clock.
  void read(ServoRig& rig, bool wall, Host& host);
  /// Sends the servo's and the scene's events.
  void send_events(ServoRig& rig, const FeltModels& models, Host& host);
  /// There is a report of the present device.
  [[nodiscard]] bool has_report() const noexcept { return has_report_; }
  void forget_report() noexcept { has_report_ = false; }
  /// A thread has begun to step the servo.
  void servo_begins() noexcept;
  /// Time since the newest report, while the host read them, s.
  [[nodiscard]] double silence_s() const noexcept;
  /// Another servo: its queues have dropped nothing.
  void begin_rig() noexcept { lost_reported_ = 0; }

  void send_position(const haptic::Report& report, const haptic::Workspace& workspace, bool always,
                     Host& host);
  /// Sends mm, vel, force and rot; `all`: also where no tag asks for them.
  void send_values(const haptic::Report& report, bool all, bool has_rotation, Host& host) const;
  /// Whether `jitter` is due, which is sent once a second.
  [[nodiscard]] bool timing_due(const Host& host) const noexcept;
  void send_timing(const haptic::ServoStatistics& statistics, Host& host);
  void send_statistics(const haptic::ServoStatistics& statistics, ServoRig& rig, Host& host) const;
  /// The message `trace`; a sentence when it is refused.
  [[nodiscard]] std::string trace(std::span<const Atom> words, ServoRig& rig, bool wall,
                                  Host& host);

private:
  void send(const haptic::ButtonEvent& event, const FeltModels& models, Host& host) const;
  void send(const haptic::WatchdogEvent& event, const FeltModels& models, Host& host) const;
  void send(const haptic::HitEvent& event, const FeltModels& models, Host& host) const;
  void send(const haptic::ContactEvent& event, const FeltModels& models, Host& host) const;
  void send(const haptic::ReleaseEvent& event, const FeltModels& models, Host& host) const;
  [[nodiscard]] double patch_ms(double servo_s) const noexcept;
  void drain_trace(ServoRig& rig);
  void watch_queues(ServoRig& rig, Host& host);

  const Reports& reports_;
  Trace trace_;
  haptic::ClockMap clock_map_; // of ServoThread's clock
  bool wall_ = false, has_report_ = false;
  double report_s_ = 0, collected_s_ = 0; // newest report, last look for one; ServoThread's clock
  std::optional<Vec3> sent_;              // position
  double last_timing_ms_ = 0, last_loss_ms_ = -1e9;
  std::uint64_t lost_reported_ = 0; // entries dropped by full queues
};

} // namespace tactus::phantom
