#pragma once

#include "core/haptic/chain/chain.hpp"
#include "core/haptic/chain/velocity.hpp"
#include "core/haptic/chain/wrist_chain.hpp"
#include "core/haptic/device/device.hpp"
#include "core/haptic/device/motor_control.hpp"
#include "core/haptic/device/workspace.hpp"
#include "core/haptic/servo/mailbox.hpp"
#include "core/haptic/servo/pacer.hpp"
#include "core/haptic/servo/ring.hpp"
#include "core/haptic/servo/statistics.hpp"

#include <atomic>

namespace tactus::haptic {

/// A source of time that only goes forward; tests inject their own.
class Clock {
public:
  virtual ~Clock() = default;
  [[nodiscard]] virtual double now_s() noexcept = 0;
};

/// A force that is computed inside the servo from the newest state, such as contact with a scene.
class LocalModel {
public:
  virtual ~LocalModel() = default;
  /// A device has been attached: what was remembered of the last one's motion no longer holds.
  virtual void begin() noexcept {}
  /// N, project frame. Bounded time, no allocation.
  [[nodiscard]] virtual Vec3 force(const Tick& tick, const State& state) noexcept = 0;
};

/// What the host wants: newest wins.
struct Command {
  Vec3 force_n{};
  std::uint64_t number = 0;  ///< counts accepted forces
  std::uint64_t refused = 0; ///< counts forces that were not finite
  bool last_refused = false;
  double heartbeat_s = 0; ///< when the host wrote this, in the servo's time
};

struct ServoSettings {
  ChainSettings chain{};
  AxisMap map{};
};

/// A device's failure: it says so itself, or it does not answer any more.
enum class Fault { kNone, kReported, kSilent };

/// What the servo saw and did in its newest tick; position, velocity and force in the project
/// frame.
struct Report {
  Tick tick{};
  State state{};
  Vec3 force_n{};
  WristCommand wrist{}; ///< zero while it is off
  ChainCounters counters{};
  double energy_j = 0, lowest_energy_j = 0;
  bool motors = true, latched = false;
  bool derating = false;      ///< the motors' heat lowers the force limit
  double derated_to_n = 0;    ///< what the limit then settles at
  double heat_n2 = 0;         ///< of the motors, as ThermalLimit counts it
  Fault fault = Fault::kNone; ///< of the device, until the motors are enabled
  std::uint32_t faults = 0;   ///< how many there were since the device was attached
};

struct Event {
  enum class Kind { kButton, kWatchdog };
  Kind kind = Kind::kButton;
  int number = 0; ///< of a button
  bool on = false;
  double time_s = 0;
};

struct ServoStatistics {
  std::uint64_t ticks = 0, overruns = 0, skipped = 0, device_errors = 0;
  DurationHistogram lateness{}, work{};
};

/// Both directions between the host's thread and the servo's; every member has one writing and one
/// reading side. Under a logical clock both sides are the same thread.
struct Exchange {
  Mailbox<Command> commands;
  Mailbox<ServoSettings> settings;
  Mailbox<WristRequest> wrist;
  MotorControl motors;
  std::atomic<std::uint32_t> statistics_resets{0}; ///< counted up: begin the statistics anew
  Mailbox<Report> reports;
  Mailbox<ServoStatistics> statistics; ///< every kStatisticsTicks ticks
  Ring<Event, 1024> events;
  std::atomic<bool> tracing{false}; ///< every tick's report goes into trace
  Ring<Report, 1024> trace;
};

/// The servo: one step reads the device, runs the chain and writes the force. It has no thread of
/// its own; whoever has the time calls step() on a logical clock or wake() on a real one.
class Servo {
public:
  static constexpr std::uint64_t kStatisticsTicks = 128;

  /// While no step runs. Starts with no force, fresh chain and statistics; an emergency stop and a
  /// failure of the last device go on until the motors are enabled. The second model's force
  /// is the patch's own, that comes tick by tick: it is not interpolated, and what it does to the
  /// hand is within the passivity controller's allowance, as for commands.
  void attach(Backend& device, LocalModel* model = nullptr, LocalModel* patch = nullptr) noexcept;
  void detach() noexcept { device_ = nullptr; }
  /// While no step runs: the heat of the motors that are attached next, N^2 (thermal.hpp). Else
  /// attach keeps that of the last ones.
  void set_motor_heat(double heat_n2) noexcept { chain_.thermal = ThermalLimit(heat_n2); }
  /// While no step runs: the device's abilities have changed.
  void refresh_caps() noexcept;
  [[nodiscard]] bool attached() const noexcept { return device_ != nullptr; }

  Exchange& exchange() noexcept { return exchange_; }

  void step(const Tick& tick) noexcept;
  /// After the last step, in the same thread: zero force. False when the device did not take it.
  bool release() noexcept;

  void start(Clock& clock, double period_s) noexcept { pacer_.start(clock.now_s(), period_s); }
  [[nodiscard]] double deadline_s() const noexcept { return pacer_.deadline_s(); }
  /// Runs the tick that is due and counts how late it is and how long it took.
  void wake(Clock& clock) noexcept;
  /// Runs one tick now, for a driver that keeps the time itself: what comes later after the last
  /// tick than the period is its lateness.
  void step_from_driver(Clock& clock, double period_s) noexcept;

  [[nodiscard]] const ChainState& chain() const noexcept { return chain_; }
  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return statistics_; }

private:
  void apply_requests(const Tick& tick) noexcept;
  void control_motors() noexcept;
  void reset_statistics() noexcept;
  State read_state(const Tick& tick) noexcept;
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
};

} // namespace tactus::haptic
