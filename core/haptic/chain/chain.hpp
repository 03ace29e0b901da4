#pragma once

#include "core/haptic/chain/passivity.hpp"
#include "core/haptic/chain/thermal.hpp"
#include "core/haptic/device/workspace.hpp"

#include <cstdint>

/// The safety chain: nothing reaches a motor without it. One pure step over a state, shared by
/// every device and by the haptic server; docs/phantom.md has the equations and the reasons.
///
///   interpolate -> + patch's signal, local model, damping, walls -> clamp -> watchdog and enable
///   gain -> passivity -> slew -> clamp
///
/// A tick costs bounded time, allocates nothing and takes any input. The written force is finite
/// and no longer than force_limit_n whatever comes in.
namespace tactus::haptic {

struct ChainSettings {
  enum class Interpolation { kAuto, kOff, kFixed };

  double period_s = 1e-3;
  double force_limit_n = 8;
  double slew_n_per_s = 2000;
  Interpolation interpolation = Interpolation::kAuto;
  double interpolation_s = 0.01; ///< of kFixed
  double extrapolation_s = 0;    ///< goes on along the slope this long after a target is reached
  double hold_s = 0.1;           ///< without a sign of life before the force falls
  double ramp_s = 0.05;          ///< from full force to none, and back
  bool strict = false;           ///< force messages too must keep coming
  double enable_s = 0.5;         ///< from none to full force after motors(true)
  bool passivity = true;
  double tank_j = 5e-3;   ///< largest energy that the observer remembers to the patch's credit
  double allowance_w = 0; ///< power that targets, not local models, may put into the hand
  double damping_n_s_per_m = 0;
  double wall_n_per_m = 0; ///< stiffness of soft walls at the workspace's faces
  Workspace workspace{};

  /// What the device is; the servo takes it from its Caps.
  struct Device {
    double damping_limit_n_s_per_m = 5; ///< of what it renders quietly at 1 kHz
    double position_noise_m = 0;        ///< largest error of one reading
    int latency_ticks = 0;              ///< between a position and the force that answers it
    double continuous_force_n = 0;      ///< that its motors bear for ever; 0: not known
  } device{};
};

/// What one tick brings.
struct ChainInput {
  double time_s = 0;      ///< any origin, never decreasing
  double heartbeat_s = 0; ///< when the host last showed that it is alive, same origin
  Vec3 position{};        ///< m
  Vec3 velocity{};        ///< m/s
  Vec3 local_force{};     ///< N, of models that live inside the servo
  Vec3 patch_force{};     ///< N, what the patch adds at this very tick
  bool homed = true;      ///< else positions mean nothing yet, and there is no force
  bool warm = false;      ///< the device says that its motors are warm
};

struct ChainCounters {
  std::uint64_t ticks = 0, clamped = 0, slewed = 0, watchdog_trips = 0, refused = 0;
  std::uint64_t braked = 0;  ///< ticks in which the passivity controller acted
  std::uint64_t derated = 0; ///< ticks in which the motors' heat lowered the limit
};

struct ChainState {
  // interpolation, in ticks
  Vec3 start{}, target{}, commanded{};
  std::uint64_t tick = 0, command_tick = 0;
  std::uint64_t length = 1;
  bool has_commanded = false, has_slope = false;

  // signs of life
  double command_s = 0, refused_since_s = 0, previous_s = 0;
  bool refusing = false, started = false, tripped = false;
  double alive_gain = 1;

  // motors
  bool motors = true, latched = false;
  double enable_gain = 1;

  Vec3 patch_force{}; // the patch's share of the last force, before clamp and slew
  Vec3 slewed{};      // output of the slew stage
  Vec3 written{};     // what the device holds now
  Vec3 position{};
  PassivityController passivity{};
  double energy_j = 0, lowest_energy_j = 0; // the controller's
  double allowance_j = 0;                   // of the patch's work, not given back yet
  ThermalLimit thermal{};
  bool derating = false;   ///< the motors' heat lowers the force limit noticeably
  double derated_to_n = 0; ///< what the limit then settles at
  ChainCounters counters{};
};

/// A new target; a component that is not finite makes the whole target refused (returns false).
/// The last good target then stays, for no longer than the watchdog's hold time.
bool command(ChainState&, const ChainSettings&, const Vec3& force_n, double time_s) noexcept;
/// Counts a target that was refused before it got here.
void refuse(ChainState&, double time_s) noexcept;

/// On: the force returns over enable_s, a latched stop is released. Off: it falls by the slew.
void motors(ChainState&, bool on) noexcept;
/// No force at once, and none until motors(true).
void emergency_stop(ChainState&) noexcept;

/// One tick; returns the force to write.
Vec3 step(ChainState&, const ChainSettings&, const ChainInput&) noexcept;

} // namespace tactus::haptic
