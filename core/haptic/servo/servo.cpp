#include "core/haptic/servo/servo.hpp"

namespace tactus::haptic {
namespace {
constexpr double kSilenceTimeout_s = 0.02; // time without an answer after which the device has
                                           // failed

ChainSettings::Device device_of(const Caps& caps) noexcept {
  ChainSettings::Device device;
  if (caps.damping_limit_n_s_per_m > 0)
    device.damping_limit_n_s_per_m = caps.damping_limit_n_s_per_m;
  device.position_noise_m = caps.position_noise_m;
  device.latency_ticks = caps.latency_ticks;
  device.continuous_force_n = caps.continuous_force_n;
  return device;
}

/// Whether the device has found its origin and the position is valid.
bool is_located(const State& state) noexcept {
  return (state.flags & State::kHomed) && !(state.flags & State::kUnreachable);
}

} // namespace

void Servo::attach(Backend& device, LocalModel* model, LocalModel* patch) noexcept {
  device_ = &device;
  model_ = model;
  patch_ = patch;
  for (LocalModel* one : {model_, patch_})
    if (one)
      one->begin();
  driver_ticks_ = 0;
  refresh_caps();
  const ChainState last = chain_;
  chain_ = {};
  chain_.thermal = last.thermal; // the motors stay as warm as they were
  chain_.counters = last.counters;
  chain_.lowest_energy_j = last.lowest_energy_j;
  wrist_.reset();
  located_ = true; // the models have begun
  located_position_.reset();
  state_ = {};
  state_.flags = 0; // not homed: no force before the first reading
  failed_reads_ = failed_writes_ = 0;
  tripped_ = has_heartbeat_ = false;
  faults_ = 0;
  exchange_.commands.read();
  command_ = exchange_.commands.latest();
  const MotorControl::Request request = exchange_.motors.request();
  if (request.enable_count != request_.enable_count && !request.stopped)
    fault_ = Fault::kNone;
  request_ = request;
  if (request.stopped || fault_ != Fault::kNone)
    emergency_stop(chain_);
  if (!request.on || request.paused)
    motors(chain_, false);
}

void Servo::refresh_caps() noexcept {
  if (!device_)
    return;
  caps_ = device_->caps();
  estimator_.reset();
  estimator_.set_bound(caps_.position_noise_m);
}

void Servo::apply_requests(const Tick& tick) noexcept {
  if (exchange_.settings.read())
    settings_ = exchange_.settings.latest();
  settings_.chain.period_s = tick.period_s;
  settings_.chain.device = device_of(caps_);
  control_motors();
  if (exchange_.statistics_resets.load(std::memory_order_relaxed) != statistics_resets_)
    reset_statistics();
  if (!exchange_.commands.read())
    return;
  const Command& newest = exchange_.commands.latest();
  const bool is_new = newest.number != command_.number;
  const bool refused = newest.refused != command_.refused;
  if (refused && !newest.last_refused)
    refuse(chain_, newest.heartbeat_s);
  if (is_new)
    command(chain_, settings_.chain, newest.force_n, newest.heartbeat_s);
  if (refused && newest.last_refused)
    refuse(chain_, newest.heartbeat_s);
  command_ = newest;
  has_heartbeat_ = true;
}

/// Applies the requests since the last tick. A stop and a later enable both count, in that order.
void Servo::control_motors() noexcept {
  const MotorControl::Request request = exchange_.motors.request();
  if (request == request_)
    return;
  if (request.stopped || request.stop_count != request_.stop_count)
    emergency_stop(chain_);
  if (request.enable_count != request_.enable_count && !request.stopped) {
    motors(chain_, true);
    fault_ = Fault::kNone;
    failed_reads_ = failed_writes_ = 0;
  }
  if (!request.on || request.paused) {
    motors(chain_, false);
  } else if (!chain_.motors) { // after a pause: an emergency stop remains in effect
    const bool latched = chain_.latched;
    motors(chain_, true);
    chain_.latched = latched;
  }
  request_ = request;
}

void Servo::reset_statistics() noexcept {
  statistics_resets_ = exchange_.statistics_resets.load(std::memory_order_relaxed);
  statistics_ = {};
  chain_.counters = {};
  chain_.lowest_energy_j = chain_.energy_j;
}

void Servo::continue_statistics(const Report& last, const ServoStatistics& statistics) noexcept {
  chain_.counters = last.counters;
  chain_.lowest_energy_j = last.lowest_energy_j;
  statistics_ = statistics;
}

State Servo::read_state(const Tick& tick) noexcept {
  State raw;
  if (!device_->read(tick, raw) || !is_finite(raw.position)) {
    ++statistics_.device_errors;
    if (++failed_reads_ * tick.period_s >= kSilenceTimeout_s)
      fail(Fault::kSilent);
    return state_;
  }
  failed_reads_ = 0;
  if (raw.flags & State::kFault)
    fail(Fault::kReported);
  State state = raw;
  state.position = settings_.map.to_project(raw.position);
  state.rotation = settings_.map.rotation_to_project(raw.rotation);
  state.velocity = caps_.has_velocity && is_finite(raw.velocity)
                       ? settings_.map.to_project(raw.velocity)
                       : estimator_.update(state.position, tick.time_s);
  if (!is_located(state)) { // the origin may still change, which is no motion
    state.velocity = {};
    estimator_.reset();
  }
  return state;
}

/// While the device has no valid position, the models get the last valid position. When the
/// position becomes valid, the models are restarted there, so that the jump of the position
/// produces no contact.
State Servo::shown_to_models(const State& state) noexcept {
  const bool located = is_located(state);
  if (located && !located_)
    for (LocalModel* one : {model_, patch_})
      if (one)
        one->begin();
  if (located || !located_position_)
    located_position_ = state.position;
  located_ = located;
  State shown = state;
  shown.position = *located_position_;
  return shown;
}

void Servo::fail(Fault fault) noexcept {
  if (fault_ != Fault::kNone)
    return;
  fault_ = fault;
  ++faults_;
  emergency_stop(chain_);
}

void Servo::push_events(const Tick& tick, const State& state) noexcept {
  for (std::uint32_t changed = state.buttons ^ state_.buttons; changed; changed &= changed - 1) {
    int number = 0;
    while (!(changed >> number & 1u))
      ++number;
    exchange_.events.push(ButtonEvent{number, (state.buttons >> number & 1u) != 0, tick.time_s});
  }
  if (chain_.tripped != tripped_)
    exchange_.events.push(WatchdogEvent{chain_.tripped, tick.time_s});
  tripped_ = chain_.tripped;
}

/// Runs after the force's chain, whose gains it uses, and before the write.
WristCommand Servo::drive_wrist(const Tick& tick, bool homed) noexcept {
  exchange_.wrist.read();
  const WristRequest& request = exchange_.wrist.latest();
  if (!request.on) {
    wrist_.reset();
    return {};
  }
  const WristCommand command = wrist_.step(request.command, chain_, caps_, homed, tick.period_s);
  device_->set_wrist({settings_.map.torque_to_device(command.torque_n_m), command.grip_n});
  return command;
}

void Servo::write_force(const Vec3& force) noexcept {
  if (device_->write(settings_.map.to_device(force))) {
    failed_writes_ = 0;
    return;
  }
  ++statistics_.device_errors;
  if (++failed_writes_ * settings_.chain.period_s >= kSilenceTimeout_s)
    fail(Fault::kSilent);
}

Report Servo::report(const Tick& tick, const State& state, const Vec3& force,
                     const WristCommand& wrist) const noexcept {
  Report report;
  report.tick = tick;
  report.state = state;
  report.force_n = force;
  report.wrist = wrist;
  report.counters = chain_.counters;
  report.energy_j = chain_.energy_j;
  report.lowest_energy_j = chain_.lowest_energy_j;
  report.asked_n = chain_.asked_n;
  report.taken_n = chain_.taken_n;
  report.clipping = chain_.clipping;
  report.braking = chain_.braking;
  report.frozen = chain_.frozen;
  report.motors = chain_.motors;
  report.latched = chain_.latched;
  report.derating = chain_.derating;
  report.derated_to_n = chain_.derated_to_n;
  report.heat_n2 = chain_.thermal.heat_n2();
  report.fault = fault_;
  report.faults = faults_;
  return report;
}

void Servo::step(const Tick& tick) noexcept {
  if (!device_)
    return;
  apply_requests(tick);
  const State state = read_state(tick);

  ChainInput input;
  input.time_s = tick.time_s;
  input.heartbeat_s = has_heartbeat_ ? command_.heartbeat_s : tick.time_s;
  input.position = state.position;
  input.velocity = state.velocity;
  input.homed = is_located(state);
  input.warm = (state.flags & State::kMotorsHot) != 0;
  const State shown = shown_to_models(state);
  if (model_)
    input.local_force = model_->force(tick, shown);
  if (patch_)
    input.patch_force = patch_->force(tick, shown);
  const Vec3 force = haptic::step(chain_, settings_.chain, input);
  const WristCommand wrist = drive_wrist(tick, input.homed);
  write_force(force);
  exchange_.motors.confirm(request_,
                           failed_writes_ == 0 && force == Vec3{} && wrist == WristCommand{});

  push_events(tick, state);
  state_ = state;
  ++statistics_.ticks;
  const Report newest = report(tick, state, force, wrist);
  exchange_.reports.write(newest);
  if (exchange_.tracing.load(std::memory_order_relaxed))
    exchange_.trace.push(newest);
  if (statistics_.ticks % kStatisticsTicks == 0)
    exchange_.statistics.write(statistics_);
}

bool Servo::release() noexcept {
  if (device_ && !device_->write({})) // without set_wrist: no torque and no grip either
    return false;
  exchange_.motors.confirm(exchange_.motors.request(), true);
  return true;
}

void Servo::wake(Clock& clock) noexcept {
  const double now_s = clock.now_s();
  const Pacer::Wake wake = pacer_.wake(now_s);
  statistics_.lateness.add(wake.lateness_s);
  if (wake.skipped > 0)
    ++statistics_.overruns;
  statistics_.skipped += wake.skipped;
  step(wake.tick);
  statistics_.work.add(clock.now_s() - now_s);
}

void Servo::step_from_driver(Clock& clock, double period_s) noexcept {
  const double now_s = clock.now_s();
  const double late_s = driver_ticks_ > 0 ? std::max(now_s - driver_tick_s_ - period_s, 0.0) : 0.0;
  statistics_.lateness.add(late_s);
  if (late_s >= period_s)
    ++statistics_.overruns;
  driver_tick_s_ = now_s;
  step({driver_ticks_++, now_s, period_s});
  statistics_.work.add(clock.now_s() - now_s);
}

} // namespace tactus::haptic
