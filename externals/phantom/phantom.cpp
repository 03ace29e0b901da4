#include "externals/phantom/phantom.hpp"

#include <algorithm>
#include <cmath>
#include <string>

/// Stepping the servo, sending to the outlets, and the messages that concern several parts. The
/// file connection.cpp opens and closes the device.
namespace tactus {
namespace {

// Interval of the heartbeats to a servo that runs on the wall clock.
constexpr double kHeartbeat_ms = 5;
// Lower bound of the time between two wake-ups.
constexpr double kShortestWake_ms = 1e-3;

} // namespace

using namespace phantom;

Phantom::Phantom() {
  apply_settings();
  apply_simulation();
}

Phantom::~Phantom() { let_go(); }

void Phantom::created(Host& host) {
  created_ = true;
  audio_.publish(host);
  motors_.set_name(audio_.name(), host);
  if (!link_.is_real())
    connect_simulation(host);
}

void Phantom::configure_signals() noexcept {
  using Time = haptic::SignalLink::Time;
  session_.rig().signals->configure(
      session_.wall ? Time::kWall : Time::kLogical, 1.0 / link_.period_s(),
      {[](void* self) { static_cast<Phantom*>(self)->step_with_audio(); }, this});
}

/// Starts the time grids of servo ticks and outputs at the present time.
void Phantom::begin_grids(Host& host) {
  ticks_.begin(host.now_ms());
  outputs_.begin(host.now_ms());
}

/// Starts to step the servo of the open device.
void Phantom::begin(Host& host) {
  begin_grids(host);
  scheduling_reported_ = false;
  models_.check_network(host);
  session_.rig().signals->set_origin(1e-3 * host.created_ms());
  configure_signals();
  if (session_.wall) {
    session_.publish(session_.now_s(host));
    const std::string refusal = link_.is_real() ? link_.request_run(host) : session_.start();
    if (!refusal.empty())
      return without_thread(refusal, host);
    if (link_.is_real())
      host.wake_in(kWatchWorker, 0);
  }
  host.wake_in(kSchedule, 0);
}

/// Called when the system provided no thread for the servo; reports that and closes the device.
void Phantom::without_thread(const std::string& refusal, Host& host) {
  host.error((session_.wall && !link_.is_real() ? "clock wall: " : "open: ") + refusal);
  disconnect(host);
}

void Phantom::scalar(std::size_t inlet, double value, Host& host) {
  forces_.set(inlet, value);
  host.wake_in(kForces, 0);
}

void Phantom::set_forces(Words words, Host& host) {
  for (const Atom& atom : words)
    if (atom.is_word)
      return host.error(expected("list", atom, "three numbers, fx fy fz"));
  for (std::size_t inlet = 3; inlet-- > 0;)
    scalar(inlet, words[inlet].number, host);
}

void Phantom::tick(std::size_t timer, Host& host) {
  if (timer == kForces)
    return forces_.apply(setup_.force_limit_n(), host);
  if (timer == kWatchWorker)
    return watch_worker(host);
  if (const std::string refusal = session_.take_refusal(); !refusal.empty())
    return without_thread(refusal, host);
  if (restart_grids_) {
    restart_grids_ = false;
    begin_grids(host);
    models_.check_network(host);
  }
  if (!link_.is_open())
    return;
  audio_.publish_again(host);
  const double now_ms = host.now_ms(), period_s = link_.period_s();
  if (session_.wall)
    session_.publish(session_.now_s(host));
  else if (ticks_.take(now_ms, 1e3 * period_s) && !audio_.steps(host))
    session_.step(session_.now_s(host), period_s);
  collect(host);
  if (output_hz_ > 0 && outputs_.take(now_ms, 1e3, output_hz_)) {
    send_values(false, host);
    output_.send_position(setup_.workspace(), repeat_, host);
  }
  schedule(host);
}

void Phantom::schedule(Host& host) {
  if (!link_.is_open())
    return; // opening restarts the grids
  const double now = host.now_ms();
  double next = now + kHeartbeat_ms;
  if (!session_.wall)
    next = std::min(next, ticks_.next_ms(now, 1e3 * link_.period_s()));
  if (output_hz_ > 0)
    next = std::min(next, outputs_.next_ms(now, 1e3, output_hz_));
  host.wake_in(kSchedule, std::max(kShortestWake_ms, next - now));
}

/// The audio calls it at the sample of each tick.
void Phantom::step_with_audio() noexcept {
  if (!link_.is_open() || session_.wall)
    return;
  const double due_s = session_.rig().signals->due_s(), period_s = link_.period_s();
  session_.step(std::isfinite(due_s) ? due_s : session_.stepped_s() + period_s, period_s);
}

/// Reads the servo's reports and events, and sends the events and the changes of device and force
/// chain.
void Phantom::collect(Host& host) {
  output_.read(host);
  setup_.learn();
  output_.send_events(host);
  motors_.report(host);
  const haptic::Report* const report = session_.report();
  if (link_.is_open() && report &&
      output_.watch_chain(*report, setup_.force_limit_n(), link_.driver_name(), host)) {
    motors_.switch_off();
    host.error(std::string(link_.driver_name()) +
               ": the host froze for longer than the watchdog's time: no force until motors 1 "
               "(with resume 1 it returns automatically)");
  }
  watch_device(host);
  if (!session_.wall || !link_.is_open() || (link_.is_real() && !link_.runs()))
    return;
  const std::string_view scheduling = session_.thread()->scheduling();
  if (!scheduling_reported_ && !scheduling.empty()) {
    scheduling_reported_ = true;
    reports_.send(kStatus, {"status", "sched", scheduling}, host);
  }
  output_.send_timing(threaded(), host);
}

void Phantom::send_values(bool all, Host& host) {
  const haptic::Report* const report = session_.report();
  if (!report)
    return;
  output_.send_values(*report, all, all && link_.device().caps().has_rotation, host);
  wrist_.send(*report, all, host);
}

void Phantom::send_all(Host& host) {
  collect(host);
  send_values(true, host);
  output_.send_position(setup_.workspace(), true, host);
}

void Phantom::send_statistics(Words words, Host& host) {
  if (!words.empty() && !is(words[0], "reset"))
    return host.error(expected("stats", words[0], "reset"));
  if (!words.empty()) {
    ++session_.exchange().statistics_resets;
    return;
  }
  collect(host);
  output_.send_statistics(threaded(), host);
}

void Phantom::change_rate() noexcept {
  restart_grids();
  link_.change_rate();
  simulation_.apply();
  if (link_.is_open())
    configure_signals();
}

void Phantom::set_clock(const Atom& clock, Host& host) {
  if (is(clock, "logical") && link_.is_real() && link_.state != DeviceLink::State::kClosed)
    return host.error("clock logical: a real device cannot be stepped by the patch's time");
  if (is(clock, "auto"))
    clock_ = Clock::kAuto;
  else if (is(clock, "logical"))
    clock_ = Clock::kLogical;
  else if (is(clock, "wall"))
    clock_ = Clock::kWall;
  else
    return host.error(expected("clock", clock, "auto, logical or wall"));
  if (link_.is_real())
    return; // a real device always runs on the wall clock
  session_.wall = clock_ == Clock::kWall;
  if (!created_ || !link_.is_open())
    return;
  session_.fade_out();
  link_.attach();
  begin(host);
}

void Phantom::set_name(const Atom& name, Host& host) {
  audio_.withdraw(host);
  audio_.set_name(text_of(name));
  if (!created_)
    return; // created() does the rest
  if (!audio_.publish(host))
    host.error("name " + audio_.name() +
               ": another phantom has this name; phantom~ connects to that one");
  motors_.set_name(audio_.name(), host);
}

void Phantom::dump(Host& host) {
  host.info({"backend", link_.driver_name()});
  host.info({"name", std::string_view(audio_.name())});
  host.info({"clock", session_.wall ? "wall" : "logical"});
  host.info({"estop", session_.exchange().motors.request().stopped ? 1.0 : 0.0});
  setup_.dump(host);
  models_.dump(host);
  if (!link_.is_real())
    simulation_.dump(host);
}

} // namespace tactus
