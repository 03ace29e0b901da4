#include "externals/phantom/device/drivers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/words.hpp"

/// Choosing, opening and closing [phantom]'s device, and the faults of an open device.
namespace tactus {

using namespace phantom;
using State = DeviceLink::State;

namespace {

constexpr double kWatchInterval_ms = 50;

} // namespace

void Phantom::send_status(std::string_view word, Host& host) const {
  reports_.send(kStatus, {"status", word, link_.driver_name()}, host);
}

void Phantom::choose_driver(Words words, Host& host) {
  DriverChoice choice = phantom::choose_driver(words);
  if (!choice.refusal.empty())
    return host.error(choice.refusal);
  const bool simulated = !choice.driver;
  if (!simulated || link_.is_real()) {
    disconnect(host);
    link_.choose(choice.driver, std::move(choice.device));
  }
  if (simulated && created_ && !link_.is_open())
    connect_simulation(host);
}

void Phantom::connect_simulation(Host& host) {
  if (const std::string refusal = link_.simulated.open(); !refusal.empty())
    return host.error(refusal);
  link_.state = State::kOpen;
  session_.wall = clock_ == Clock::kWall;
  link_.attach();
  setup_.apply();
  begin(host);
  send_status("open", host);
}

void Phantom::connect(Words which, Host& host) {
  if (!link_.is_real()) {
    if (!which.empty() && (which[0].is_word || which[0].number != 0))
      return host.error(
          expected("open", which[0],
                   "nothing or 0, the only simulated device; choose another driver with backend"));
    if (!created_)
      return; // created() opens the device
    disconnect(host);
    return connect_simulation(host);
  }
  if (clock_ == Clock::kLogical)
    return host.error("open: a real device cannot be stepped by the patch's time; send clock auto "
                      "or clock wall first");
  if (clock_ == Clock::kAuto && !host.real_time())
    return host.error("open: a batch render does not run in real time; send "
                      "clock wall first to use a real device all the same");
  disconnect(host);
  if (const std::string refusal = link_.select(which); !refusal.empty())
    return host.error(refusal);
  motors_.switch_off();
  link_.state = State::kOpening;
  send_status("opening", host);
  request_open(host);
}

void Phantom::request_open(Host& host) {
  if (const std::string refusal = link_.request_open(host); !refusal.empty())
    return closed("open: " + refusal, host);
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

void Phantom::disconnect(Host& host) {
  if (link_.state == State::kClosed)
    return;
  if (link_.is_real()) {
    end_session(host);
  } else {
    session_.fade_out();
    session_.rig().servo.detach();
    session_.leave_audio();
    static_cast<void>(link_.simulated.write({}));
    link_.simulated.close();
  }
  closed({}, host);
}

/// Leaves the real device and its servo to the worker, which lets the force fall and closes the
/// device, or gives up opening it. The object continues with a new servo.
void Phantom::end_session(Host& host) {
  if (link_.is_open())
    collect(host);
  const bool runs = link_.is_open(); // collect() may have found that the device is lost
  if (runs) {
    session_.leave_audio();
    session_.exchange().motors.pause(true);
  }
  if (const std::string refusal = link_.request_close(host); !refusal.empty())
    host.error("close: " + refusal);
  if (runs)
    replace_rig(host);
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

/// Called when the device is closed; reports that and the reason, if any.
void Phantom::closed(std::string_view why, Host& host) {
  link_.state = State::kClosed;
  motors_.end_device();
  if (link_.is_real())
    session_.forget_report();
  if (!why.empty())
    host.error(why);
  send_status("closed", host);
}

/// Makes a new servo with the same settings, scene, network and name. The old servo then belongs to
/// the thread that ends it.
void Phantom::replace_rig(Host& host) {
  motors_.store_heat();
  session_.replace();
  wrist_.publish();
  models_.publish();
  audio_.replace(host);
  output_.begin_rig();
  setup_.apply();
}

void Phantom::posted(Host& host) {
  using Kind = DeviceJob::Answer::Kind;
  const auto answer = link_.take(host);
  if (!answer)
    return;
  switch (answer->kind) {
  case Kind::kOpened:
    return opened(host);
  case Kind::kRefused:
    trouble_.send(answer->sentence, host);
    return closed(answer->sentence, host);
  case Kind::kTrouble:
    return trouble_.report(answer->sentence, host);
  case Kind::kRunning:
    return output_.servo_begins();
  case Kind::kNotRunning:
    trouble_.send(answer->sentence, host);
    host.error(std::string(link_.driver_name()) + ": " + answer->sentence);
    return disconnect(host);
  }
}

/// Repeated while the worker is busy. Abandons a thread whose call does not return.
void Phantom::watch_worker(Host& host) {
  const std::string late = link_.abandon_overdue();
  if (late.empty()) {
    if (link_.busy())
      host.wake_in(kWatchWorker, kWatchInterval_ms);
    return;
  }
  host.error(late + " has not returned for 1 s; its thread is abandoned. Switch the device off "
                    "and on; if it cannot be opened then, restart the host");
  if (link_.state == State::kOpening)
    return request_open(host); // the opening was queued behind the abandoned call
  if (link_.is_real() && link_.state != State::kClosed) {
    if (link_.is_open())
      replace_rig(host);
    closed({}, host);
  }
}

void Phantom::opened(Host& host) {
  link_.state = State::kOpen;
  session_.wall = true;
  session_.forget_report();
  setup_.use_workspace();
  trouble_.begin(host);
  motors_.begin_device(link_.driver_name(), link_.device().identity().serial, host);
  link_.attach();
  setup_.apply();
  send_status("open", host);
  if (reports_.on(kStatus))
    link_.send_identity(host);
  if (link_.device().caps().axes_out == 0)
    send_status("noforce", host);
  models_.warn(host);
  begin(host);
}

/// Reports changes of a real device's state, faults and troubles.
void Phantom::watch_device(Host& host) {
  if (!link_.is_real() || !link_.is_open())
    return;
  const auto fault = trouble_.watch(output_.silence_s(), host);
  if (!fault)
    return;
  if (*fault == haptic::Fault::kReported)
    handle_device_fault(host);
  else
    handle_lost_device(host);
}

/// Called when the device no longer answers. Closes it and tries to open it again until it answers.
void Phantom::handle_lost_device(Host& host) {
  const std::string problem = link_.device().trouble();
  session_.leave_audio();
  link_.state = State::kLost;
  motors_.switch_off();
  host.error(std::string(link_.driver_name()) +
             ": the device no longer answers: check its cable and power. It is opened again "
             "when it returns; its motors stay off until motors 1" +
             (problem.empty() ? "" : " (" + problem + ")"));
  if (!problem.empty())
    trouble_.report(problem, host);
  send_status("lost", host);
  const std::string refusal = link_.request_open(host, true);
  replace_rig(host);
  host.wake_in(kWatchWorker, 0);
  if (!refusal.empty())
    closed(refusal, host);
}

/// Called when the device reports a failure but still answers.
void Phantom::handle_device_fault(Host& host) {
  motors_.emergency_stop();
  const std::string problem = link_.device().trouble();
  host.error(
      "the device has failed and its motors stay off until motors 1: " +
      (problem.empty() ? std::string(link_.driver_name()) + ": check the device first" : problem));
  if (!problem.empty())
    trouble_.report(problem, host);
  reports_.send(kStatus, {"status", "fault", 1.0}, host);
  motors_.report(host);
}

/// Also called when the host's program ends without deleting the object.
void Phantom::let_go() noexcept {
  session_.leave_audio();
  if (!link_.is_real()) {
    session_.fade_out();
    session_.rig().servo.detach();
  } else {
    session_.exchange().motors.pause(true);
    if (link_.is_open())
      motors_.store_heat();
  }
  link_.let_go();
}

} // namespace tactus
