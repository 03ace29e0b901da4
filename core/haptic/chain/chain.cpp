#include "core/haptic/chain/chain.hpp"

namespace tactus::haptic {
namespace {

// Larger inputs are shortened so that differences and products of them stay finite.
constexpr double kMaxTarget_n = 1e6;
constexpr double kMaxLocalForce_n = 1e6;
constexpr double kMaxPosition_m = 1e3;
constexpr double kMaxSpeed_m_per_s = 1e4;
constexpr double kNoticed_s = 0.5;
// A change of the force that a hand may notice: 5 % of the force, and at least 20 mN.
constexpr double kNoticeableShare = 0.05, kNoticeable_n = 0.02;
constexpr std::uint64_t kMaxAutoInterpolation_ticks = 50;

std::uint64_t ticks_of(double seconds, double period_s) noexcept {
  const double ticks = std::floor(seconds / period_s + 0.5);
  return ticks >= 1.0 ? static_cast<std::uint64_t>(std::min(ticks, 1e6)) : 0;
}

Vec3 interpolated(ChainState& state, const ChainSettings& settings) noexcept {
  const std::uint64_t elapsed = state.tick - state.command_tick + 1;
  const double length = static_cast<double>(state.interpolation_ticks);
  const Vec3 delta = state.target - state.start;
  if (elapsed < state.interpolation_ticks)
    return state.start + delta * (static_cast<double>(elapsed) / length);
  if (!state.has_slope || settings.extrapolation_s <= 0.0)
    return state.target;
  const std::uint64_t beyond = std::min(elapsed - state.interpolation_ticks,
                                        ticks_of(settings.extrapolation_s, settings.period_s));
  if (beyond == 0)
    return state.target;
  return limited(state.target + delta * (static_cast<double>(beyond) / length),
                 std::max(settings.force_limit_n, norm(state.target)));
}

Vec3 soft_walls(const ChainSettings& settings, const Vec3& position) noexcept {
  Vec3 force;
  for (int axis = 0; axis < 3; ++axis) {
    const double inside =
        std::clamp(position[axis], settings.workspace.min[axis], settings.workspace.max[axis]);
    force[axis] = settings.wall_n_per_m * (inside - position[axis]);
  }
  return force;
}

double watchdog_gain(ChainState& state, const ChainSettings& settings, const ChainInput& input,
                     double elapsed_s) noexcept {
  double silence_s = input.time_s - input.heartbeat_s;
  if (settings.strict)
    silence_s = std::max(silence_s, input.time_s - state.command_s);
  if (state.refusing)
    silence_s = std::max(silence_s, input.time_s - state.refused_since_s);
  const double overdue_s = silence_s - settings.hold_s;
  const double ramp_s = std::max(settings.ramp_s, 1e-9);
  if (!settings.resume && input.time_s - input.heartbeat_s - settings.hold_s > 1e-9)
    state.frozen = true;
  if (overdue_s > 1e-9 || state.frozen) {
    state.alive_gain -= (overdue_s > 1e-9 ? std::min(elapsed_s, overdue_s) : elapsed_s) / ramp_s;
    if (!state.tripped)
      ++state.counters.watchdog_trips;
    state.tripped = true;
  } else {
    state.alive_gain += elapsed_s / ramp_s;
    state.tripped = false;
  }
  if (state.alive_gain < 1e-12)
    state.alive_gain = 0.0; // removes the rounding error of the sum
  return state.alive_gain = std::min(state.alive_gain, 1.0);
}

PassivitySettings passivity_of(const ChainSettings& settings) noexcept {
  return {settings.period_s,
          settings.slew_n_per_s,
          settings.tank_j,
          settings.allowance_w,
          settings.passivity,
          settings.device.damping_limit_n_s_per_m,
          settings.device.position_noise_m,
          settings.device.latency_ticks};
}

/// The force limit of this tick, lowered while the motors are warm.
double force_limit(ChainState& state, const ChainSettings& settings, double elapsed_s,
                   bool warm) noexcept {
  // The actual time, because a late tick has held the force for longer. Drivers cut the force of a
  // servo that stalls for more than this (core/haptic/device/force_timeout.hpp).
  constexpr double kMaxHold_s = 0.05;
  const ThermalSettings motors{std::min(elapsed_s, kMaxHold_s), settings.force_limit_n,
                               settings.device.continuous_force_n};
  state.thermal.advance(motors, norm(state.written), warm);
  const double ceiling_n = state.thermal.ceiling_n(motors);
  state.derating = state.thermal.derating();
  state.derated_to_n = state.thermal.steady_limit_n(motors);
  return ceiling_n;
}

/// The input with bounded, finite vectors; a position that is not finite becomes the last position.
ChainInput bounded(ChainInput input, const Vec3& last_position) noexcept {
  input.position =
      is_finite(input.position) ? limited(input.position, kMaxPosition_m) : last_position;
  input.velocity = limited(input.velocity, kMaxSpeed_m_per_s);
  return input;
}

void start(ChainState& state, const ChainSettings& settings, const ChainInput& input) noexcept {
  state.started = true;
  state.previous_s = input.time_s - settings.period_s;
  state.position = input.position;
  if (!state.has_commanded)
    state.command_s = input.time_s;
}

/// True if `now` is true or was true within the last kNoticed_s.
bool noticed(double& left_s, bool now, double elapsed_s) noexcept {
  left_s = now ? kNoticed_s : std::max(left_s - elapsed_s, 0.0);
  return left_s > 0.0;
}

Vec3 slew_limited(ChainState& state, const ChainSettings& settings, const Vec3& force) noexcept {
  const Vec3 change = force - state.slewed;
  const double max_change = settings.slew_n_per_s * settings.period_s;
  if (!(norm(change) > max_change))
    return force;
  ++state.counters.slewed;
  return state.slewed + limited(change, max_change);
}

} // namespace

bool command(ChainState& state, const ChainSettings& settings, const Vec3& force_n,
             double time_s) noexcept {
  if (!is_finite(force_n)) {
    refuse(state, time_s);
    return false;
  }
  const bool first = !state.has_commanded;
  const std::uint64_t since = state.tick - state.command_tick;
  using Interpolation = ChainSettings::Interpolation;
  switch (settings.interpolation) {
  case Interpolation::kAuto:
    if (first)
      state.interpolation_ticks = 1;
    else if (since > 0)
      state.interpolation_ticks =
          std::min(since, kMaxAutoInterpolation_ticks); // since == 0: a second command in this tick
    break;
  case Interpolation::kOff:
    state.interpolation_ticks = 1;
    break;
  case Interpolation::kFixed:
    state.interpolation_ticks =
        std::max<std::uint64_t>(1, ticks_of(settings.interpolation_s, settings.period_s));
    break;
  }
  // A first target, or one reached at once, has no slope to extrapolate.
  state.has_slope = !first && settings.interpolation != Interpolation::kOff;
  state.start = state.commanded;
  state.target = limited(force_n, kMaxTarget_n);
  state.command_tick = state.tick;
  state.has_commanded = true;
  state.command_s = time_s;
  state.refusing = false;
  return true;
}

void refuse(ChainState& state, double time_s) noexcept {
  ++state.counters.refused;
  if (!state.refusing)
    state.refused_since_s = time_s;
  state.refusing = true;
}

void motors(ChainState& state, bool on) noexcept {
  if (on && (!state.motors || state.latched || state.frozen))
    state.enable_gain = 0.0;
  if (on)
    state.latched = state.frozen = false;
  state.motors = on;
}

void emergency_stop(ChainState& state) noexcept {
  state.latched = true;
  state.written = state.slewed = {};
}

Vec3 step(ChainState& state, const ChainSettings& settings, const ChainInput& raw_input) noexcept {
  const ChainInput input = bounded(raw_input, state.position);
  if (!state.started)
    start(state, settings, input);
  const double elapsed_s = std::clamp(input.time_s - state.previous_s, 0.0, 10.0);
  state.previous_s = input.time_s;

  state.commanded = interpolated(state, settings);

  const Vec3 patch_force = state.commanded + limited(input.patch_force, kMaxLocalForce_n);
  Vec3 contact = limited(input.local_force, kMaxLocalForce_n);
  if (settings.wall_n_per_m > 0.0)
    contact += limited(soft_walls(settings, input.position), kMaxLocalForce_n);
  Vec3 force = patch_force + contact;
  force -= limited(input.velocity * settings.damping_n_s_per_m, kMaxLocalForce_n);

  const double limit_n = force_limit(state, settings, elapsed_s, input.warm);
  const double length = state.asked_n = norm(force);
  state.clipping = noticed(state.clipping_s, length > settings.force_limit_n, elapsed_s);
  if (length > settings.force_limit_n)
    ++state.counters.clamped;
  else if (length > limit_n)
    ++state.counters.derated;
  const double clamp_gain = length > limit_n ? limit_n / length : 1.0;
  force = limited(force, limit_n);

  state.enable_gain =
      std::min(1.0, state.enable_gain + elapsed_s / std::max(settings.enable_s, 1e-9));
  const double alive = watchdog_gain(state, settings, input, elapsed_s);
  const double gain = state.motors ? alive * state.enable_gain : 0.0;
  force = force * gain;

  const PassivitySettings passivity = passivity_of(settings);
  state.passivity.observe(passivity, input.position, state.written);
  state.energy_j = state.passivity.energy_j();
  state.lowest_energy_j = std::min(state.lowest_energy_j, state.energy_j);
  const Vec3 contact_part = contact * (clamp_gain * gain);
  const PassivityController::Parts passive =
      state.passivity.limit(passivity, {contact_part, force - contact_part}, input.velocity);
  state.taken_n = state.passivity.taken_n();
  state.counters.braked += state.taken_n > 0.0 ? 1 : 0;
  state.braking =
      noticed(state.braking_s,
              state.taken_n > std::max(kNoticeableShare * norm(force), kNoticeable_n), elapsed_s);
  force = limited(passive.contact + passive.command, limit_n);

  force = limited(slew_limited(state, settings, force), settings.force_limit_n);
  state.slewed = force;
  if (state.latched || !input.homed) {
    state.slewed = {};
    state.enable_gain = 0.0;
    force = {};
  }
  state.position = input.position;
  state.written = force;
  ++state.tick;
  ++state.counters.ticks;
  return force;
}

} // namespace tactus::haptic
