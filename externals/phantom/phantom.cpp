#include "externals/phantom/phantom.hpp"

#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/net_driver.hpp"
#include "externals/phantom/signal_link_name.hpp"
#include "externals/phantom/tags.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>
#include <utility>

/// Time: what steps the servo, and when the outlets send.
namespace tactus {
namespace {

// Times of two grids that coincide differ by rounding only.
constexpr double kTimeTolerance_ms = 1e-6;
// Interval of the heartbeats to a servo on the wall clock.
constexpr double kHeartbeat_ms = 5;
// Lower bound of the time between two wake-ups.
constexpr double kShortestWake_ms = 1e-3;
constexpr double kGraceful_s = 0.2;
// Audio that has not run for this long, and two blocks, no longer steps the servo.
constexpr double kAudioTimeout_ms = 20;
constexpr std::uint64_t kPublishInterval_ticks = 64; // ticks

} // namespace

using namespace phantom;

Phantom::Phantom() {
  add_net_driver();
  apply_settings();
  apply_simulation_settings();
}

Phantom::~Phantom() {
  let_go();
  rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {});
}

double Phantom::period_s() const noexcept {
  if (driver_ && open() && device_->owns_thread())
    return 1.0 / std::clamp(device_->caps().rate_hz, 1.0, 1e5);
  return 1.0 / given_.rate_hz;
}

/// Ramps the force down at the slew limit, for at most 200 ms, and ends the simulated device's
/// thread. For a real device the worker ends the servo.
void Phantom::fade_out() noexcept {
  if (driver_ || !runner_->running())
    return;
  exchange().motors.pause(true);
  const double give_up_s = devices::ServoThread::now_s() + kGraceful_s;
  while (!exchange().motors.zero_force_confirmed() && devices::ServoThread::now_s() < give_up_s)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  static_cast<void>(runner_->stop()); // waits: a simulated step cannot hang
  exchange().motors.pause(false);
}

void Phantom::rate_changed() {
  restart_grids_ = true;
  if (running_ && !device_->owns_thread())
    runner_->set_period(period_s());
  apply_simulation_settings();
  if (open())
    configure_signals();
}

void Phantom::switch_motors(bool on) noexcept {
  given_.motors = on;
  set_motors();
  apply_settings();
}

/// Sends the chain's parameters to the servo.
void Phantom::apply_settings() noexcept {
  auto& chain = settings_.chain;
  chain.force_limit_n = given_.forcemax_n;
  const double peak_n = device().caps().peak_force_n;
  if (peak_n > 0)
    chain.force_limit_n = std::min(chain.force_limit_n, peak_n);
  chain.slew_n_per_s = given_.slew_n_per_ms * 1e3;
  chain.extrapolation_s = given_.extrap_ms * 1e-3;
  chain.strict = given_.strict;
  chain.resume = !driver_ || given_.resume;
  chain.passivity = given_.passivity;
  chain.tank_j = given_.tank_j;
  chain.allowance_w = given_.allowance_w;
  chain.damping_n_s_per_m = given_.damp_n_s_per_m;
  chain.wall_n_per_m = given_.walls_n_per_m;
  exchange().settings.write(settings_);
  rig_->signals->set_workspace(chain.workspace);
}

/// Sets the simulated device's parameters; restarts the thread that steps it, with the present
/// rate.
void Phantom::apply_simulation_settings() noexcept {
  simulation_.mass_kg = given_simulation_.mass_kg;
  simulation_.viscous_n_s_per_m = given_simulation_.viscous_n_s_per_m;
  simulation_.stops = given_simulation_.stops;
  simulation_.resolution_m = given_simulation_.resolution_mm * 1e-3;
  simulation_.noise_m = given_simulation_.noise_mm * 1e-3;
  simulation_.seed = simulation_.hand.seed = static_cast<std::uint64_t>(given_simulation_.seed);
  simulation_.latency_ticks = static_cast<int>(given_simulation_.latency_ticks);
  with_simulation([this] {
    const haptic::Caps before = simulated_.caps();
    simulated_.set(simulation_);
    const haptic::Caps now = simulated_.caps();
    if (!driver_ && (now.position_noise_m != before.position_noise_m ||
                     now.damping_limit_n_s_per_m != before.damping_limit_n_s_per_m ||
                     now.latency_ticks != before.latency_ticks))
      rig_->servo.refresh_caps();
  });
  if (!driver_)
    update_limits();
}

void Phantom::created(Host& host) {
  created_ = true;
  signals_published_ = host.publish(signal_link_name(name_), rig_->signals);
  if (name_ != "-")
    inherit_stop(name_key(name_), host);
  if (!driver_)
    connect_simulation(host);
}

/// Sends the device's limits to the models in the servo.
void Phantom::update_limits() noexcept {
  rig_->scene.set_continuous_force(device().caps().continuous_force_n);
  rig_->effects.set_damping_limit(device().caps().damping_limit_n_s_per_m);
}

void Phantom::attach() noexcept {
  update_limits();
  if (driver_) {
    rig_->device = device_;
    rig_->servo.attach(*device_, &rig_->local_models, &rig_->patch_models);
  } else {
    rig_->servo.attach(simulated_, &rig_->local_models, &rig_->patch_models);
  }
  faults_ = 0;
}

void Phantom::configure_signals() noexcept {
  using Time = haptic::SignalLink::Time;
  rig_->signals->configure(
      wall_ ? Time::kWall : Time::kLogical, 1.0 / period_s(),
      {[](void* self) { static_cast<Phantom*>(self)->step_with_audio(); }, this});
}

/// Starts the grids of servo ticks and of outputs at the present time.
void Phantom::begin(Host& host) {
  origin_ms_ = output_origin_ms_ = host.now_ms();
  steps_ = outputs_ = 0;
  scheduling_reported_ = false;
  if (open()) {
    check_network(host);
    rig_->signals->set_origin(1e-3 * host.created_ms());
    configure_signals();
    if (wall_) {
      publish(devices::ServoThread::now_s());
      if (std::string refusal = driver_ ? worker(host).run({rig_, runner_}, period_s(), ticket_)
                                        : runner_->start(rig_->servo, period_s());
          !refusal.empty())
        return without_thread(refusal, host);
      if (driver_)
        host.wake_in(kWatchWorker, 0);
    }
  }
  host.wake_in(kSchedule, 0);
}

/// The system provided no thread for the servo: reports that and closes the device.
void Phantom::without_thread(const std::string& refusal, Host& host) {
  thread_refusal_.clear();
  host.error((wall_ && !driver_ ? "clock wall: " : "open: ") + refusal);
  disconnect(host);
}

void Phantom::restart(Host& host) {
  if (!created_ || !open())
    return;
  fade_out();
  attach();
  begin(host);
}

void Phantom::scalar(std::size_t inlet, double value, Host& host) {
  if (std::isfinite(value)) {
    input_force_[static_cast<int>(inlet)] = value;
    input_changed_ = true;
  } else {
    input_refused_ = true;
  }
  host.wake_in(kForces, 0);
}

void Phantom::publish(double now_s) noexcept {
  command_.heartbeat_s = now_s;
  exchange().commands.write(command_);
}

/// Values that arrive at several inlets in one logical instant form one force.
void Phantom::force_changed(Host& host) {
  if (input_refused_) {
    ++command_.refused;
    command_.last_refused = true;
    if (host.now_ms() - last_error_ms_ >= 1000) {
      last_error_ms_ = host.now_ms();
      host.error(
          "force: not a finite number; the last valid force stays until the watchdog ends it");
      if (reported_[kError])
        host.info({"error", "nan", "force", "refused"});
    }
  } else if (input_changed_) {
    const double unit_n = given_.in_shares_of_limit ? settings_.chain.force_limit_n : 1.0;
    command_.force_n = input_force_ * unit_n;
    ++command_.number;
    command_.last_refused = false;
  }
  input_refused_ = input_changed_ = false;
  publish(wall_ ? devices::ServoThread::now_s() : host.now_ms() * 1e-3);
}

void Phantom::tick(std::size_t timer, Host& host) {
  if (timer == kForces)
    return force_changed(host);
  if (timer == kWatchWorker)
    return watch_worker(host);
  if (!thread_refusal_.empty())
    return without_thread(std::exchange(thread_refusal_, {}), host);
  if (restart_grids_) {
    restart_grids_ = false;
    origin_ms_ = output_origin_ms_ = host.now_ms();
    steps_ = outputs_ = 0;
    check_network(host);
  }
  if (!open())
    return;
  // An object that had the name may have been deleted.
  if (!signals_published_ && ++ticks_since_publish_ % kPublishInterval_ticks == 0)
    signals_published_ = host.publish(signal_link_name(name_), rig_->signals);
  const double now = host.now_ms() + kTimeTolerance_ms;
  const double period_ms = 1e3 * period_s();
  if (!wall_) {
    // One tick at most, so that a jump of the host's time causes no burst.
    if (origin_ms_ + static_cast<double>(steps_) * period_ms <= now) {
      if (!audio_steps(host))
        step(host.now_ms() * 1e-3);
      ++steps_;
    }
  } else {
    publish(devices::ServoThread::now_s());
  }
  const double rate = given_.outrate_hz;
  collect(host);
  if (rate > 0 && output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate <= now) {
    ++outputs_;
    send_values(host, false);
    send_position(host, given_.repeat);
  }
  schedule(host);
}

void Phantom::schedule(Host& host) {
  if (!open())
    return; // opening restarts the grids
  const double now = host.now_ms(), rate = given_.outrate_hz, period_ms = 1e3 * period_s();
  double next = now + kHeartbeat_ms;
  if (!wall_) {
    // After a jump of the host's time, or a change of rate, a late grid restarts now.
    if (origin_ms_ + static_cast<double>(steps_) * period_ms < now - kTimeTolerance_ms) {
      origin_ms_ = now;
      steps_ = 1;
    }
    next = std::min(next, origin_ms_ + static_cast<double>(steps_) * period_ms);
  }
  if (rate > 0) {
    if (output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate < now - kTimeTolerance_ms) {
      output_origin_ms_ = now;
      outputs_ = 1;
    }
    next = std::min(next, output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate);
  }
  host.wake_in(kSchedule, std::max(kShortestWake_ms, next - now));
}

void Phantom::step(double now_s) noexcept {
  publish(now_s);
  stepped_s_ = now_s;
  rig_->servo.step({index_++, now_s, period_s()});
}

/// Called by the audio at the sample of each tick.
void Phantom::step_with_audio() noexcept {
  const double due_s = rig_->signals->due_s();
  if (open() && !wall_)
    step(std::isfinite(due_s) ? due_s : stepped_s_ + period_s());
}

/// Whether a [phantom~] steps the servo, so that the clock must not.
bool Phantom::audio_steps(Host& host) noexcept {
  const std::uint64_t blocks = rig_->signals->blocks();
  if (blocks != audio_blocks_) {
    audio_blocks_ = blocks;
    audio_ms_ = host.now_ms();
  }
  return host.now_ms() - audio_ms_ <= kAudioTimeout_ms + 2e3 * rig_->signals->max_block_s();
}

// One piece: a table of the messages.

} // namespace tactus
