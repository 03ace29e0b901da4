#pragma once

#include "core/dsp/mailbox.hpp"
#include "core/dsp/ring.hpp"
#include "core/haptic/chain/chain.hpp"
#include "core/haptic/chain/velocity.hpp"
#include "core/haptic/chain/wrist_chain.hpp"
#include "core/haptic/device/device.hpp"
#include "core/haptic/device/motor_control.hpp"
#include "core/haptic/device/workspace.hpp"
#include "core/haptic/servo/pacer.hpp"
#include "core/haptic/servo/statistics.hpp"

#include <atomic>
#include <optional>
#include <variant>

namespace tactus::haptic {

/// A clock that never goes back. Tests inject their own.
class Clock {
public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual double now_s() noexcept = 0;
};

/// A model that computes a force inside the servo from the newest state, such as contact with a
/// scene.
class LocalModel {
public:
  virtual ~LocalModel() = default;
  /// A device has been attached: the motion of the last one is no longer valid.
  virtual void begin() noexcept {}
  /// N, project frame. Bounded time, no allocation.
  [[nodiscard]] virtual Vec3 force(const Tick& tick, const State& state) noexcept = 0;
};

/// The host's force command. The newest one counts.
struct Command {
  Vec3 force_n{};
  std::uint64_t number = 0;  ///< counts accepted forces
  std::uint64_t refused = 0; ///< counts forces that were not finite
  bool last_refused = false;
  double heartbeat_s = 0; ///< time of this command on the servo's clock
};

struct ServoSettings {
  ChainSettings chain{};
  AxisMap map{};
};

/// Failure of a device: the device reports a fault, or it no longer answers.
enum class Fault { kNone, kReported, kSilent };

/// Input and output of the newest tick; position, velocity and force in the project frame.
struct Report {
  Tick tick{};
  State state{};
  Vec3 force_n{};
  WristCommand wrist{}; ///< zero while it is off
  ChainCounters counters{};
  double energy_j = 0, lowest_energy_j = 0;
  double asked_n = 0, taken_n = 0;        ///< forces as in ChainState
  bool clipping = false, braking = false; ///< flags as in ChainState
  bool frozen = false;                    ///< flag as in ChainState
  bool motors = true, latched = false;
  bool derating = false;      ///< as ThermalLimit::derating()
  double derated_to_n = 0;    ///< as ThermalLimit::steady_limit_n()
  double heat_n2 = 0;         ///< as ThermalLimit::heat_n2()
  Fault fault = Fault::kNone; ///< failure of the device, kept until the motors are enabled
  std::uint32_t faults = 0;   ///< number of faults since the device was attached
};

/// A button has been pressed or released.
struct ButtonEvent {
  int number = 0;
  bool on = false;
  double time_s = 0;
};
/// The watchdog has tripped or recovered.
struct WatchdogEvent {
  bool on = false;
  double time_s = 0;
};
using ServoEvent = std::variant<ButtonEvent, WatchdogEvent>;

/// Counters and timing since the last reset.
struct ServoStatistics {
  std::uint64_t ticks = 0, overruns = 0, skipped = 0, device_errors = 0;
  DurationHistogram lateness{}, work{};
};

/// Everything that the host's thread and the servo's exchange. Every member has one writing and one
/// reading side. Under a logical clock both sides are the same thread.
struct Exchange {
  Mailbox<Command> commands;
  Mailbox<ServoSettings> settings;
  Mailbox<WristRequest> wrist;
  MotorControl motors;
  std::atomic<std::uint32_t> statistics_resets{0}; ///< a change resets the statistics
  Mailbox<Report> reports;
  Mailbox<ServoStatistics> statistics; ///< every kStatisticsTicks ticks
  Ring<ServoEvent, 1024> events;
  std::atomic<bool> tracing{false}; ///< true: every tick pushes its report to trace
  Ring<Report, 1024> trace;
};

/// The servo loop of a haptic device: one step reads the device, evaluates the local models, runs
/// the safety chain (chain.hpp) and writes the force. It has no thread of its own. The owner calls
/// step() on a logical clock, wake() from a thread with a real clock, or step_from_driver() where
/// the device's driver calls back.
class Servo {
public:
  static constexpr std::uint64_t kStatisticsTicks = 128;

  /// Starts with zero force and a new chain. An emergency stop and a failure of the last device
  /// stay in effect until the motors are enabled; the statistics continue until they are reset.
  /// `model` must be passive. The force of `patch` is treated like the host's commands, but not
  /// interpolated: the passivity controller allows its work up to allowance_w. Not to be called
  /// while a step runs.
  void attach(Backend& device, LocalModel* model = nullptr, LocalModel* patch = nullptr) noexcept;
  void detach() noexcept { device_ = nullptr; }
  /// Sets the heat of the motors, N^2 (thermal.hpp), before attach(); without it attach() keeps the
  /// heat of the last device. Not to be called while a step runs.
  void set_motor_heat(double heat_n2) noexcept { chain_.thermal = ThermalLimit(heat_n2); }
  /// Continues the statistics of the servo that this servo replaces. Not to be called while a step
  /// runs.
  void continue_statistics(const Report& last, const ServoStatistics& statistics) noexcept;
  /// Reads the device's Caps again after they have changed. Not to be called while a step runs.
  void refresh_caps() noexcept;

  Exchange& exchange() noexcept { return exchange_; }

  void step(const Tick& tick) noexcept;
  /// Writes zero force after the last step, in the same thread. False when the device refused it.
  bool release() noexcept;

  void start(Clock& clock, double period_s) noexcept { pacer_.start(clock.now_s(), period_s); }
  [[nodiscard]] double deadline_s() const noexcept { return pacer_.deadline_s(); }
  /// Runs the tick that is due; its lateness and duration go into the statistics.
  void wake(Clock& clock) noexcept;
  /// Runs one tick now, for a driver that has its own timing. The lateness is the time since the
  /// last tick beyond the period.
  void step_from_driver(Clock& clock, double period_s) noexcept;

  [[nodiscard]] const ChainState& chain() const noexcept { return chain_; }
  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return statistics_; }

private:
  void apply_requests(const Tick& tick) noexcept;
  void control_motors() noexcept;
  void reset_statistics() noexcept;
  State read_state(const Tick& tick) noexcept;
  [[nodiscard]] State shown_to_models(const State& state) noexcept;
  void write_force(const Vec3& force) noexcept;
  [[nodiscard]] Report report(const Tick& tick, const State& state, const Vec3& force,
                              const WristCommand& wrist) const noexcept;
  WristCommand drive_wrist(const Tick& tick, bool homed) noexcept;
  void push_events(const Tick& tick, const State& state) noexcept;
  void fail(Fault fault) noexcept;

  Exchange exchange_;
  Backend* device_ = nullptr;
  LocalModel *model_ = nullptr, *patch_ = nullptr;
  Caps caps_{};
  ServoSettings settings_{};
  ChainState chain_{};
  WristChain wrist_{};
  VelocityEstimator estimator_{};
  Pacer pacer_{};
  ServoStatistics statistics_{};
  State state_{};
  Command command_{};
  std::uint64_t driver_ticks_ = 0;
  double driver_tick_s_ = 0;
  MotorControl::Request request_{};
  std::uint32_t statistics_resets_ = 0, faults_ = 0;
  int failed_reads_ = 0, failed_writes_ = 0;
  Fault fault_ = Fault::kNone;
  bool tripped_ = false, has_heartbeat_ = false;
  bool located_ = true;
  std::optional<Vec3> located_position_{}; ///< the last position that was known, m
};

} // namespace tactus::haptic
