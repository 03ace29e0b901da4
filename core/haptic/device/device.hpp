#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>
#include <span>
#include <string>

/// The interface of a haptic device: position in, force out. Real devices live in devices/, the
/// simulated one beside this file.
namespace tactus::haptic {

/// One tick of the servo loop. The index counts the points of the time grid since the start,
/// including those that an overrun skipped: index * period_s is the planned time, time_s the actual
/// time.
struct Tick {
  std::uint64_t index = 0;
  double time_s = 0;
  double period_s = 1e-3;
};

/// Capabilities of a device. A limit of zero means that the device does not state it.
struct Caps {
  int axes_in = 3, axes_out = 3;
  double peak_force_n = 0, continuous_force_n = 0;
  double stiffness_limit_n_per_m = 0, damping_limit_n_s_per_m = 0;
  Vec3 workspace_min{-0.05, -0.05, -0.05}, workspace_max{0.05, 0.05, 0.05}; ///< m
  double rate_hz = 1000;
  double position_noise_m = 0; ///< largest error of one reading, encoder step included
  /// Ticks between a reading and the first tick in which the force computed from it acts. The usual
  /// number is 1, because of the delays of the bus in both directions. 0 only for a device that is
  /// known to have no such delay.
  int latency_ticks = 1;
  bool has_velocity = false; ///< State::velocity is measured; else the servo estimates it
  bool has_buttons = false;
  bool needs_home = false;
  bool has_rotation = false;  ///< State::rotation is measured
  double peak_torque_n_m = 0; ///< peak torque of the wrist's motors; 0: there are none
  double peak_grip_n = 0;     ///< peak force of the gripper's motor; 0: there is none
  bool has_gripper = false;   ///< State::gripper_m is measured
};

/// Names that a device reports; empty if it reports none.
struct Identity {
  std::string vendor, model, serial;
};

/// One reading of a device.
struct State {
  enum Flags : std::uint32_t {
    kHomed = 1,
    kFault = 2,
    kMotorsHot = 4,
    kForceLimited = 8,
    /// The newest reading lies outside the device's reach; position is the last good one. The force
    /// of this tick is zero; the force then returns by the enable ramp, as after the motors are
    /// switched on.
    kUnreachable = 16
  };
  Vec3 position{};      ///< m, project frame
  Vec3 velocity{};      ///< m/s
  Vec3 rotation{};      ///< rad about x, y, z; for a sprung knob, its deflection, -1..1
  double gripper_m = 0; ///< opening of the gripper
  std::uint32_t buttons = 0;
  std::uint32_t flags = kHomed;
};

/// Torque on the handle and force of the gripper, for devices that have motors for them.
struct WristCommand {
  Vec3 torque_n_m{}; ///< about x, y, z of the same frame as the force
  double grip_n = 0; ///< with the sign of the device's library; a positive force is assumed to open
                     ///< the gripper
  friend bool operator==(const WristCommand&, const WristCommand&) = default;
};

/// Replaces a position that is not finite, or farther from the workspace's centre than four times
/// its half diagonal, by last_good, sets the velocity to zero and sets kUnreachable. A position
/// within reach becomes the new last_good. For drivers whose library or service gives positions;
/// the driver stores last_good.
void reject_unreachable(const Caps& caps, State& state, Vec3& last_good) noexcept;

/// A haptic device. open and close may take seconds and allocate: they run in a thread that may
/// wait, never while the servo steps. read and write run in the servo's thread; they neither
/// allocate nor throw, nor block for more than 2 ms. configure may be called at any time.
class Backend {
public:
  virtual ~Backend() = default;
  /// Empty when the device is ready, else one sentence that tells the user what to do.
  [[nodiscard]] virtual std::string open() = 0;
  /// Asks a running open() to give up: it returns its sentence within 0.3 s if the device's library
  /// allows this. May be called from any thread, also when nothing is being opened. A later open()
  /// is not affected, so the caller repeats the request until open() has returned.
  virtual void cancel() noexcept {}
  virtual void close() noexcept = 0;
  [[nodiscard]] virtual Caps caps() const noexcept = 0;
  /// The state at this tick; false when the device did not answer.
  [[nodiscard]] virtual bool read(const Tick& tick, State& state) noexcept = 0;
  /// Force in N, held by the device until the next write; false when it could not be sent.
  [[nodiscard]] virtual bool write(const Vec3& force_n) noexcept = 0;
  /// Torque and gripper force of the next write only: a write without a preceding call sends
  /// neither. Called in the servo's thread. A device without motors for them ignores it.
  virtual void set_wrist(const WristCommand& command) noexcept { static_cast<void>(command); }
  /// One setting that only this device has, such as "firmware FILE" or "speed 100", or "device
  /// WHICH" (an index, serial number or path) before it is opened. Empty when accepted, else one
  /// sentence with what was expected. Takes effect between two ticks or at the next opening.
  [[nodiscard]] virtual std::string configure(std::span<const std::string> words);
  [[nodiscard]] virtual Identity identity() const { return {}; }
  /// One sentence on a problem of the opened device and its remedy; empty if there is none. Called
  /// from any thread that may wait, also while read and write run.
  [[nodiscard]] virtual std::string trouble() const { return {}; }

  /// True when the device's own driver calls the servo's step.
  [[nodiscard]] virtual bool owns_thread() const noexcept { return false; }
  /// For a device that owns its thread: calls step(context) at the driver's rate until halt().
  /// False when the driver's scheduler does not start.
  [[nodiscard]] virtual bool run(void (*step)(void* context), void* context) {
    static_cast<void>(step);
    static_cast<void>(context);
    return false;
  }
  /// Ends the calls of step; returns when none is running.
  virtual void halt() noexcept {}
};

} // namespace tactus::haptic
