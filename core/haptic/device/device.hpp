#pragma once

#include "core/geometry/vec3.hpp"

#include <cstdint>
#include <span>
#include <string>

/// What a haptic device is to the rest of tactus. Real devices live in devices/, the simulated one
/// beside this file.
namespace tactus::haptic {

/// One instant of the servo. Index counts grid points since the start, those skipped by an overrun
/// included, so that index * period_s is the planned time and time_s the real one.
struct Tick {
  std::uint64_t index = 0;
  double time_s = 0;
  double period_s = 1e-3;
};

/// What a device can do. Zero for a limit means that the device does not know it.
struct Caps {
  int axes_in = 3, axes_out = 3;
  double peak_force_n = 0, continuous_force_n = 0;
  double stiffness_limit_n_per_m = 0, damping_limit_n_s_per_m = 0;
  Vec3 workspace_min{-0.05, -0.05, -0.05}, workspace_max{0.05, 0.05, 0.05}; ///< m
  double rate_hz = 1000;
  double position_noise_m = 0; ///< largest error of one reading, encoder step included
  /// Ticks between a position and the first that feels the force which answers it. One is usual: a
  /// reading is as old as the bus, and the force goes out behind it. 0 only where that is known.
  int latency_ticks = 1;
  bool has_velocity = false; ///< State::velocity is measured; else the servo estimates it
  bool has_buttons = false;
  bool needs_home = false;
  bool has_rotation = false;  ///< State::rotation is measured
  double peak_torque_n_m = 0; ///< of the wrist's motors; 0: it has none
  double peak_grip_n = 0;     ///< of the gripper's motor; 0: it has none
  bool has_gripper = false;   ///< State::gripper_m is measured
};

/// Who a device is, as far as it says.
struct Identity {
  std::string vendor, model, serial;
};

struct State {
  enum Flags : std::uint32_t {
    kHomed = 1,
    kFault = 2,
    kMotorsHot = 4,
    kForceLimited = 8,
    /// The newest reading is no position that the device can have; position is the last good one.
    /// There is no force at this tick, and it returns as after motors on.
    kUnreachable = 16
  };
  Vec3 position{};      ///< m, project frame
  Vec3 velocity{};      ///< m/s
  Vec3 rotation{};      ///< rad about x, y, z; of a sprung knob its share of full deflection, -1..1
  double gripper_m = 0; ///< how far the gripper is open
  std::uint32_t buttons = 0;
  std::uint32_t flags = kHomed;
};

/// For devices with more motors than three: torque on the handle and force of the gripper.
struct WristCommand {
  Vec3 torque_n_m{}; ///< about x, y, z of the same frame as the force
  double grip_n = 0; ///< positive as the device's library counts it, taken for opening
  friend bool operator==(const WristCommand&, const WristCommand&) = default;
};

/// Puts the state's position right: one that is not finite, or lies farther from the workspace's
/// centre than four times its half diagonal, becomes the last good one and sets kUnreachable. For
/// drivers whose library or service gives positions; last_good is theirs to keep.
void reject_unreachable(const Caps& caps, State& state, Vec3& last_good) noexcept;

/// A device. open and close may take seconds and allocate: they run in a thread of the host's that
/// may wait, never while the servo steps. read and write neither allocate, block for more than 2
/// ms, nor throw, and run in the servo's thread. configure may be called at any time.
class Backend {
public:
  virtual ~Backend() = default;
  /// Empty when the device is ready, else one sentence that says what to do.
  [[nodiscard]] virtual std::string open() = 0;
  /// Ask an open() that is under way to end: it returns its sentence within 0.3 s, wherever the
  /// device's library lets it. For any thread, and harmless when nothing is being opened; the next
  /// open() starts afresh, so the caller repeats the request until open() has returned.
  virtual void cancel() noexcept {}
  virtual void close() noexcept = 0;
  [[nodiscard]] virtual Caps caps() const noexcept = 0;
  /// State at this tick; false when the device did not answer.
  [[nodiscard]] virtual bool read(const Tick& tick, State& state) noexcept = 0;
  /// Force in N, held by the device until the next write; false when it could not be sent.
  [[nodiscard]] virtual bool write(const Vec3& force_n) noexcept = 0;
  /// What goes out with the next write, and with that one alone: a write that no call precedes has
  /// no torque and no gripper force. A device that is never asked is sent neither. For the servo's
  /// thread, as write; nothing happens on a device that has neither.
  virtual void set_wrist(const WristCommand& command) noexcept { static_cast<void>(command); }
  /// One setting of this device alone, such as "firmware FILE" or "speed 100", or "device WHICH"
  /// (an index, serial number or path) before it is opened. Empty when taken, else what was
  /// expected. Takes effect between two ticks or at the next opening.
  [[nodiscard]] virtual std::string configure(std::span<const std::string> words);
  [[nodiscard]] virtual Identity identity() const { return {}; }
  /// What is wrong with the opened device now, one sentence that says what to do; empty when all is
  /// well. For any thread that may wait, beside read and write.
  [[nodiscard]] virtual std::string trouble() const { return {}; }

  /// True when the device's own driver calls the servo's step.
  [[nodiscard]] virtual bool owns_thread() const noexcept { return false; }
  /// For such a device: call step(context) at the driver's rate from now on until halt, which
  /// returns when no call is under way. False when the driver's scheduler does not start.
  [[nodiscard]] virtual bool run(void (*step)(void* context), void* context) {
    static_cast<void>(step);
    static_cast<void>(context);
    return false;
  }
  virtual void halt() noexcept {}
};

} // namespace tactus::haptic
