#pragma once

#include "core/haptic/servo/clock_map.hpp"
#include "externals/phantom/output/trace.hpp"
#include "externals/phantom/reports.hpp"
#include "externals/phantom/scene/felt_models.hpp"
#include "externals/phantom/servo/servo_session.hpp"

#include <cstdint>
#include <optional>
#include <string_view>

namespace tactus::phantom {

/// Sends the servo's output to the patch: positions, events, statistics and the trace.
class ServoOutput {
public:
  ServoOutput(ServoSession& session, const FeltModels& models, const Reports& reports)
      : session_(session), models_(models), reports_(reports) {}

  /// Reads the servo's reports and writes the trace.
  void read(const Host& host);
  /// Sends the servo's and the scene's events.
  void send_events(Host& host);
  /// Call it when a thread has begun to step the servo.
  void servo_begins() noexcept;
  /// Time since the newest report, while the host read them, s.
  [[nodiscard]] double silence_s() const noexcept;
  /// Call it for a new servo, whose queues have dropped nothing yet.
  void begin_rig() noexcept { lost_reported_ = 0; }

  /// Reports how the force chain changes the force, so that the user knows why the felt force
  /// differs from the force that the patch requests. Logs the first clipping, and each time that
  /// the motors become warm. Returns true if the host has frozen.
  [[nodiscard]] bool watch_chain(const haptic::Report& report, double force_limit_n,
                                 std::string_view device, Host& host);
  /// Sends the position if it has changed, or in any case if `always` is true.
  void send_position(const haptic::Workspace& workspace, bool always, Host& host);
  /// Sends mm, vel, force and rot; `all`: sends them even if their tags are off.
  void send_values(const haptic::Report& report, bool all, bool has_rotation, Host& host) const;
  /// Sends `jitter` once a second; `threaded` is true if a thread steps the servo.
  void send_timing(bool threaded, Host& host);
  void send_statistics(bool threaded, Host& host) const;
  /// Handles the message `trace`.
  void trace(const Atom& file, Host& host);

private:
  void send(const haptic::ButtonEvent& event, Host& host) const;
  void send(const haptic::WatchdogEvent& event, Host& host) const;
  void send(const haptic::HitEvent& event, Host& host) const;
  void send(const haptic::ContactEvent& event, Host& host) const;
  void send(const haptic::ReleaseEvent& event, Host& host) const;
  [[nodiscard]] double patch_ms(double servo_s) const noexcept;
  void drain_trace();
  void watch_queues(Host& host);

  ServoSession& session_;
  const FeltModels& models_;
  const Reports& reports_;
  Trace trace_;
  haptic::ClockMap clock_map_;            // maps ServoThread's clock
  double report_s_ = 0, collected_s_ = 0; // times of the newest report and of the last read()
  std::optional<Vec3> sent_;              // last sent position
  double last_timing_ms_ = 0, last_loss_ms_ = -1e9;
  std::uint64_t lost_reported_ = 0; // reported number of entries dropped by full queues
  bool warm_ = false, clipping_ = false, braking_ = false, frozen_ = false;
  bool clipping_logged_ = false;
};

} // namespace tactus::phantom
