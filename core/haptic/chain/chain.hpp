#pragma once

#include "core/haptic/chain/passivity.hpp"
#include "core/haptic/chain/thermal.hpp"
#include "core/haptic/device/workspace.hpp"

#include <cstdint>

/// The safety chain: every force passes through it before it reaches a motor. One step function on
/// a state, used for every device and by the haptic server. docs/theory/phantom.md has the
/// equations and the reasons.
///
///   interpolation of the commands -> + signals of the patch, local models, damping, soft walls
///   -> clamp -> watchdog and enable gain -> passivity controller -> slew limit -> clamp
///
/// A step takes bounded time, allocates nothing and accepts any input. The force that it returns is
/// finite and no longer than force_limit_n.
namespace tactus::haptic {

/// Allowance of [phantom] and of the servers, W: the power that the hand's own damping of about 5 N
/// s/m dissipates at 0.1 m/s. Forces of soft springs that a patch computes one tick late therefore
/// pass unchanged.
inline constexpr double kAllowance_w = 0.05;

struct ChainSettings {
  enum class Interpolation { kAuto, kOff, kFixed };

  double period_s = 1e-3;
  double force_limit_n = 8;
  double slew_n_per_s = 2000;
  Interpolation interpolation = Interpolation::kAuto;
  double interpolation_s = 0.01; ///< duration of kFixed
  double extrapolation_s = 0;    ///< how long the slope continues after a target is reached
  double hold_s = 0.1;           ///< watchdog: time without a heartbeat before the force falls
  double ramp_s = 0.05;          ///< watchdog: time from full force to zero, and back
  bool strict = false;           ///< the watchdog expects force messages too
  bool resume = true;    ///< the force returns by itself with the heartbeat; else by motors()
  double enable_s = 0.5; ///< time from zero to full force after motors(true)
  bool passivity = true;
  double tank_j = 5e-3;   ///< largest positive energy that the observer stores
  double allowance_w = 0; ///< power that commands, not local models, may put into the hand
  double damping_n_s_per_m = 0;
  double wall_n_per_m = 0; ///< stiffness of soft walls at the workspace's faces
  Workspace workspace{};

  /// Properties of the device; the servo copies them from its Caps.
  struct Device {
    double damping_limit_n_s_per_m = 5; ///< largest damping it renders stably at 1 kHz
    double position_noise_m = 0;        ///< largest error of one reading
    int latency_ticks = 0;              ///< delay, as Caps::latency_ticks
    double continuous_force_n = 0;      ///< continuous rating of its motors; 0: not known
  } device{};
};

/// Input of one tick.
struct ChainInput {
  double time_s = 0;      ///< any origin, never decreasing
  double heartbeat_s = 0; ///< time of the host's last heartbeat, same origin
  Vec3 position{};        ///< m
  Vec3 velocity{};        ///< m/s
  Vec3 local_force{};     ///< N, of models inside the servo
  Vec3 patch_force{};     ///< N, of the patch in this tick; not interpolated
  bool homed = true;      ///< false: the position is not valid yet, and the force is zero
  bool warm = false;      ///< the device reports warm motors
};

/// Ticks since the statistics were reset, and the number of ticks in which each stage acted.
struct ChainCounters {
  std::uint64_t ticks = 0, clamped = 0, slewed = 0, watchdog_trips = 0, refused = 0;
  std::uint64_t braked = 0;  ///< ticks in which the passivity controller acted
  std::uint64_t derated = 0; ///< ticks in which the thermal limit shortened the force
};

/// State of the chain, kept from tick to tick.
struct ChainState {
  // interpolation, in ticks
  Vec3 start{}, target{}, commanded{};
  std::uint64_t tick = 0, command_tick = 0;
  std::uint64_t interpolation_ticks = 1;
  bool has_commanded = false, has_slope = false;

  // watchdog
  double command_s = 0, refused_since_s = 0, previous_s = 0;
  bool refusing = false, started = false, tripped = false;
  bool frozen = false; ///< no force until motors(true): the host was silent and resume is false
  double alive_gain = 1;

  // motors
  bool motors = true, latched = false;
  double enable_gain = 1;

  Vec3 slewed{};  // output of the slew stage
  Vec3 written{}; // the force that the device holds now
  Vec3 position{};
  PassivityController passivity{};
  double energy_j = 0, lowest_energy_j = 0; // energies of the passivity controller
  ThermalLimit thermal{};
  bool derating = false;           ///< as ThermalLimit::derating()
  double derated_to_n = 0;         ///< as ThermalLimit::steady_limit_n()
  double asked_n = 0, taken_n = 0; ///< this tick: unclamped force, change by passivity controller
  bool clipping = false, braking = false; ///< true if noticeable in the last half second
  double clipping_s = 0, braking_s = 0;   // time until they are reset
  ChainCounters counters{};
};

/// Sets a new target force. A target with a component that is not finite is refused (returns
/// false): the last good target stays until the watchdog's hold time has passed.
bool command(ChainState&, const ChainSettings&, const Vec3& force_n, double time_s) noexcept;
/// Counts a target that the caller has refused.
void refuse(ChainState&, double time_s) noexcept;

/// On: the force returns over enable_s, and an emergency stop ends. Off: the force falls at the
/// slew limit.
void motors(ChainState&, bool on) noexcept;
/// Zero force at once, until motors(true).
void emergency_stop(ChainState&) noexcept;

/// One tick; returns the force to write, N.
Vec3 step(ChainState&, const ChainSettings&, const ChainInput&) noexcept;

} // namespace tactus::haptic
