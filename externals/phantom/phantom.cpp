#include "externals/phantom/phantom.hpp"

#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/net_driver.hpp"
#include "externals/phantom/numbers.hpp"

#include <algorithm>
#include <cmath>
#include <string>

/// Time and forces: what steps the servo, when the outlets send, and what the inlets ask for.
namespace tactus {
namespace {

// Interval of the heartbeats to a servo on the wall clock.
constexpr double kHeartbeat_ms = 5;
// Lower bound of the time between two wake-ups.
constexpr double kShortestWake_ms = 1e-3;

} // namespace

using namespace phantom;

Phantom::Phantom()
    : simulation_([this](const Simulation::Change& change) {
        if (driver_)
          return change(simulation_.device);
        session_.between_ticks(period_s(), [&] { change(simulation_.device); });
      }) {
  add_net_driver();
  apply_settings();
  apply_simulation();
}

Phantom::~Phantom() {
  let_go();
  session_.leave_audio();
}

double Phantom::period_s() const noexcept {
  if (driver_ && open() && device_->owns_thread())
    return 1.0 / std::clamp(device_->caps().rate_hz, 1.0, 1e5);
  return 1.0 / rate_hz_;
}

void Phantom::created(Host& host) {
  created_ = true;
  audio_.publish(session_.rig(), host);
  if (audio_.name() != "-")
    inherit_stop(name_key(audio_.name()), host);
  if (!driver_)
    connect_simulation(host);
}

void Phantom::attach() noexcept {
  update_limits();
  if (driver_)
    session_.attach(device_);
  else
    session_.attach(simulation_.device);
  faults_ = 0;
}

void Phantom::configure_signals() noexcept {
  using Time = haptic::SignalLink::Time;
  session_.rig().signals->configure(
      wall_ ? Time::kWall : Time::kLogical, 1.0 / period_s(),
      {[](void* self) { static_cast<Phantom*>(self)->step_with_audio(); }, this});
}

/// Starts the grids of servo ticks and of outputs at the present time.
void Phantom::begin_grids(Host& host) {
  ticks_.begin(host.now_ms());
  outputs_.begin(host.now_ms());
}

void Phantom::begin(Host& host) {
  begin_grids(host);
  scheduling_reported_ = false;
  if (open()) {
    models_.check_network(period_s(), host);
    session_.rig().signals->set_origin(1e-3 * host.created_ms());
    configure_signals();
    if (wall_) {
      session_.publish(devices::ServoThread::now_s());
      if (std::string refusal =
              driver_ ? worker(host).request({ticket_,
                                              driver_,
                                              device_,
                                              false,
                                              {session_.shared_rig(), session_.thread()},
                                              period_s()})
                      : session_.start(period_s());
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
  host.error((wall_ && !driver_ ? "clock wall: " : "open: ") + refusal);
  disconnect(host);
}

void Phantom::restart(Host& host) {
  if (!created_ || !open())
    return;
  if (!driver_)
    session_.fade_out();
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

void Phantom::set_forces(Words words, Host& host) {
  for (const Atom& atom : words)
    if (atom.is_word)
      return host.error(expected("list", atom, "three numbers, fx fy fz"));
  for (std::size_t inlet = 3; inlet-- > 0;)
    scalar(inlet, words[inlet].number, host);
}

/// Values that arrive at several inlets in one logical instant form one force.
void Phantom::apply_forces(Host& host) {
  if (input_refused_) {
    ++session_.command.refused;
    session_.command.last_refused = true;
    if (host.now_ms() - last_error_ms_ >= 1000) {
      last_error_ms_ = host.now_ms();
      host.error(
          "force: not a finite number; the last valid force stays until the watchdog ends it");
      reports_.send(kError, {"error", "nan", "force", "refused"}, host);
    }
  } else if (input_changed_) {
    const double unit_n = in_shares_of_limit_ ? setup_.settings.chain.force_limit_n : 1.0;
    session_.command.force_n = input_force_ * unit_n;
    ++session_.command.number;
    session_.command.last_refused = false;
  }
  input_refused_ = input_changed_ = false;
  session_.publish(wall_ ? devices::ServoThread::now_s() : host.now_ms() * 1e-3);
}

void Phantom::tick(std::size_t timer, Host& host) {
  if (timer == kForces)
    return apply_forces(host);
  if (timer == kWatchWorker)
    return watch_worker(host);
  if (const std::string refusal = session_.take_refusal(); !refusal.empty())
    return without_thread(refusal, host);
  if (restart_grids_) {
    restart_grids_ = false;
    begin_grids(host);
    models_.check_network(period_s(), host);
  }
  if (!open())
    return;
  audio_.publish_again(session_.rig(), host);
  if (wall_) {
    session_.publish(devices::ServoThread::now_s());
  } else if (ticks_.take(host.now_ms(), 1e3 * period_s())) {
    if (!audio_.steps(session_.rig(), host))
      session_.step(host.now_ms() * 1e-3, period_s());
  }
  collect(host);
  if (output_hz_ > 0 && outputs_.take(host.now_ms(), 1e3, output_hz_)) {
    send_values(false, host);
    output_.send_position(report(), setup_.settings.chain.workspace, repeat_, host);
  }
  schedule(host);
}

void Phantom::schedule(Host& host) {
  if (!open())
    return; // opening restarts the grids
  const double now = host.now_ms();
  double next = now + kHeartbeat_ms;
  if (!wall_)
    next = std::min(next, ticks_.next_ms(now, 1e3 * period_s()));
  if (output_hz_ > 0)
    next = std::min(next, outputs_.next_ms(now, 1e3, output_hz_));
  host.wake_in(kSchedule, std::max(kShortestWake_ms, next - now));
}

/// Called by the audio at the sample of each tick.
void Phantom::step_with_audio() noexcept {
  const double due_s = session_.rig().signals->due_s();
  if (open() && !wall_)
    session_.step(std::isfinite(due_s) ? due_s : session_.stepped_s() + period_s(), period_s());
}

/// Reads the servo's reports and events, sends the events and what is new of device and chain.
void Phantom::collect(Host& host) {
  output_.read(session_.rig(), wall_, host);
  if (output_.has_report() && setup_.learn(report().state.position)) {
    exchange().settings.write(setup_.settings);
    session_.rig().signals->set_workspace(setup_.settings.chain.workspace);
  }
  output_.send_events(session_.rig(), models_, host);
  stop_.report(exchange().motors, reports_, host);
  if (open() && output_.has_report() &&
      chain_watch_.watch(report(), setup_.settings.chain.force_limit_n, driver_name(), reports_,
                         host)) {
    switch_off();
    host.error(std::string(driver_name()) +
               ": the host froze for longer than the watchdog's time: no force until motors 1 "
               "(with resume 1 it returns automatically)");
  }
  if (driver_)
    watch_device(host);
  if (!wall_ || !open() || (driver_ && !running_))
    return;
  const std::string_view scheduling = session_.thread()->scheduling();
  if (!scheduling_reported_ && !scheduling.empty()) {
    scheduling_reported_ = true;
    reports_.send(kStatus, {"status", "sched", scheduling}, host);
  }
  if (output_.timing_due(host))
    output_.send_timing(session_.statistics(driver_ || session_.in_thread()), host);
}

void Phantom::send_values(bool all, Host& host) {
  if (!output_.has_report())
    return;
  const haptic::Caps caps = all ? device().caps() : haptic::Caps();
  output_.send_values(report(), all, caps.has_rotation, host);
  wrist_.send(report(), all, caps.has_gripper, reports_, host);
}

void Phantom::send_all(Host& host) {
  collect(host);
  send_values(true, host);
  output_.send_position(report(), setup_.settings.chain.workspace, true, host);
}

void Phantom::send_statistics(Words words, Host& host) {
  if (!words.empty() && !is(words[0], "reset"))
    return host.error(expected("stats", words[0], "reset"));
  if (!words.empty()) {
    ++exchange().statistics_resets;
    return;
  }
  collect(host);
  output_.send_statistics(session_.statistics(driver_ || session_.in_thread()), session_.rig(),
                          host);
}

} // namespace tactus
