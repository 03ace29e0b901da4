#include "externals/phantom/driver_words.hpp"
#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/motor_heat.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/text.hpp"

/// Choosing, opening and closing [phantom]'s device. A worker opens, runs and closes real devices,
/// since a call of a driver may take seconds or never return. The host's thread waits for none of
/// these calls and reads the answers in posted().
namespace tactus {

using namespace phantom;
using Answer = DeviceJob::Answer;

namespace {

constexpr double kWatchInterval_ms = 50;
constexpr double kOverdue_s = 1;     // for closing a device, or for an opening that was cancelled
constexpr double kListOverdue_s = 3; // for a list
constexpr double kStall_s = 1;       // a servo without a tick for this long is reported

void report_all(const std::vector<std::string>& sentences, Host& host) {
  for (const std::string& sentence : sentences)
    host.error(sentence);
}

} // namespace

const haptic::Backend& Phantom::device() const noexcept {
  if (driver_ && open())
    return *device_;
  return simulation_.device;
}

std::string_view Phantom::driver_name() const noexcept { return driver_ ? driver_->name : "sim"; }

DeviceWorker& Phantom::worker(Host& host) {
  if (!worker_)
    worker_ = std::make_unique<DeviceWorker>([&host] { host.wake_from_thread(); });
  return *worker_;
}

void Phantom::send_status(std::string_view word, Host& host) const {
  reports_.send(kStatus, {"status", word, driver_name()}, host);
}

void Phantom::choose_driver(Words words, Host& host) {
  const devices::Driver* requested = nullptr;
  if (!is(words[0], "sim")) {
    requested = words[0].is_word ? devices::find_driver(words[0].word) : nullptr;
    if (!requested)
      return host.error(expected("backend", words[0], driver_names(true)));
  } else if (words.size() > 1) {
    return host.error("backend sim: expected no arguments");
  }
  Device made;
  if (requested) {
    made = requested->make();
    if (!made)
      return host.error("backend " + std::string(requested->name) + ": " + requested->problem());
    if (words.size() > 1)
      if (const std::string refusal = configure_new(*made, words.subspan(1)); !refusal.empty())
        return host.error("backend " + refusal);
  } else if (!driver_) {
    if (created_ && !open())
      connect_simulation(host);
    return;
  }
  disconnect(host);
  driver_ = requested;
  device_ = std::move(made);
  if (!driver_ && created_)
    connect_simulation(host);
}

void Phantom::set_driver(const Message& row, Words words, Host& host) {
  const bool general = row.name == "driver"; // else the setting's name is the message's
  if (!driver_)
    return host.error(std::string(row.name) +
                      ": only for a real device; first choose one with "
                      "backend " +
                      driver_names(false));
  std::vector<std::string> texts;
  if (!general)
    texts.emplace_back(row.name);
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  std::string asked = general ? "driver" : "";
  for (const std::string& text : texts)
    asked += (asked.empty() ? "" : " ") + text;
  if ((texts[0] == "firmware" || texts[0] == "table" || texts[0] == "token") && texts.size() == 2) {
    std::string found = host.find_file(texts[1]);
    if (found.empty())
      return host.error(texts[0] + " " + texts[1] +
                        ": file not found beside the patch or in the search path");
    texts[1] = std::move(found);
  }
  if (const std::string refused = device_->configure(texts); !refused.empty())
    host.error(asked + ": " + refused);
}

void Phantom::list_devices(Host& host) {
  host.info({"device", "sim", 0.0, "tactus", "simulated", std::string_view(audio_.name()),
             !driver_ && open() ? "open" : "closed"});
  if (devices::drivers().empty())
    return;
  if (!lister_)
    lister_ = std::make_unique<DeviceLister>([&host] { host.wake_from_thread(); });
  if (const std::string late = lister_->overdue(kListOverdue_s); !late.empty())
    return host.error("devices: " + late + " has not returned yet; the list waits for it");
  if (const std::string refusal = lister_->request({}); !refusal.empty())
    host.error("devices: " + refusal);
}

void Phantom::set_name(const Atom& name, Host& host) {
  audio_.withdraw(host);
  audio_.set_name(text_of(name));
  if (!created_)
    return; // creation does the rest
  if (!audio_.publish(session_.rig(), host))
    host.error("name " + audio_.name() +
               ": another phantom has this name; phantom~ connects to that one");
  if (exchange().motors.request().stopped)
    latch_stop();
  inherit_stop(name_key(audio_.name()), host);
}

void Phantom::connect_simulation(Host& host) {
  if (const std::string refusal = simulation_.device.open(); !refusal.empty())
    return host.error(refusal);
  link_ = Link::kOpen;
  wall_ = clock_ == Clock::kWall;
  attach();
  apply_settings();
  begin(host);
  send_status("open", host);
}

void Phantom::connect(Words which, Host& host) {
  if (!driver_) {
    if (!which.empty() && (which[0].is_word || which[0].number != 0))
      return host.error(
          expected("open", which[0],
                   "nothing or 0, the only simulated device; choose another driver with backend"));
    if (!created_)
      return; // creation opens it
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
  if (!which.empty())
    if (const std::string refusal = configure(*device_, which, true); !refusal.empty())
      return host.error(refusal);
  switch_off();
  link_ = Link::kOpening;
  send_status("opening", host);
  if (const std::string refusal = worker(host).request({++ticket_, driver_, device_});
      !refusal.empty())
    return closed("open: " + refusal, host);
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

void Phantom::disconnect(Host& host) {
  if (link_ == Link::kClosed)
    return;
  if (driver_) {
    end_session(host);
  } else {
    session_.fade_out();
    session_.rig().servo.detach();
    session_.leave_audio();
    static_cast<void>(simulation_.device.write({}));
    simulation_.device.close();
  }
  closed({}, host);
}

/// Leaves the real device and its servo to the worker, which lets the force fall and closes the
/// device, or gives up opening it. The object continues with a new servo.
void Phantom::end_session(Host& host) {
  if (open())
    collect(host);
  const bool runs = open(); // collect() may find the device lost
  if (runs) {
    session_.leave_audio();
    exchange().motors.pause(true);
  }
  if (const std::string refusal = worker(host).request({++ticket_}); !refusal.empty())
    host.error("close: " + refusal);
  if (runs)
    replace_rig(host);
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

/// The device is closed; reports that and the reason, if any.
void Phantom::closed(std::string_view why, Host& host) {
  link_ = Link::kClosed;
  if (driver_)
    output_.forget_report();
  if (!why.empty())
    host.error(why);
  send_status("closed", host);
}

/// Stores the motors' heat for the next servo that drives this device.
void Phantom::store_heat() noexcept {
  exchange().reports.read();
  store_motor_heat(device_key_, exchange().reports.latest().heat_n2, devices::ServoThread::now_s());
}

/// Makes a new servo with the same settings, scene, network and name. The old one belongs to the
/// thread that ends it.
void Phantom::replace_rig(Host& host) {
  store_heat();
  session_.replace();
  wrist_.publish(exchange());
  models_.publish(session_.rig());
  audio_.replace(session_.rig(), host);
  output_.begin_rig();
  running_ = false;
  faults_ = 0;
  apply_settings();
}

void Phantom::posted(Host& host) {
  if (lister_) {
    const auto taken = lister_->take();
    report_all(taken.sentences, host);
    if (taken.answer)
      listed(*taken.answer, host);
  }
  if (!worker_)
    return;
  const auto taken = worker_->take();
  report_all(taken.sentences, host);
  const auto& answer = taken.answer;
  if (!answer || answer->ticket != ticket_)
    return; // of a device that is not wanted any more
  switch (answer->kind) {
  case Answer::Kind::kOpened:
    opened(host);
    break;
  case Answer::Kind::kRefused:
    send_trouble(answer->sentence, driver_name(), reports_, host);
    closed(answer->sentence, host);
    break;
  case Answer::Kind::kTrouble:
    trouble_.report(answer->sentence, driver_name(), reports_, host);
    break;
  case Answer::Kind::kRunning:
    running_ = true;
    output_.servo_begins();
    session_.thread()->set_period(period_s());
    break;
  case Answer::Kind::kNotRunning:
    send_trouble(answer->sentence, driver_name(), reports_, host);
    host.error(std::string(driver_name()) + ": " + answer->sentence);
    disconnect(host);
    break;
  }
}

/// While the worker is busy: cancels an opening that is no longer requested, and abandons a thread
/// whose call does not return.
void Phantom::watch_worker(Host& host) {
  if (!worker_)
    return;
  worker_->cancel_unwanted();
  const std::string late = worker_->overdue(kOverdue_s);
  if (late.empty()) {
    if (worker_->busy())
      host.wake_in(kWatchWorker, kWatchInterval_ms);
    return;
  }
  const bool again = link_ == Link::kOpening;
  worker_.reset(); // the thread keeps what it works on, and ends when the call returns
  host.error(late + " has not returned for 1 s; its thread is abandoned. Switch the device off "
                    "and on; if it cannot be opened then, restart the host");
  if (again) { // the new opening was queued behind that call
    if (const std::string refusal = worker(host).request({++ticket_, driver_, device_});
        !refusal.empty())
      return closed("open: " + refusal, host);
    return host.wake_in(kWatchWorker, kWatchInterval_ms);
  }
  if (driver_ && link_ != Link::kClosed) {
    if (open())
      replace_rig(host);
    closed({}, host);
  }
}

void Phantom::opened(Host& host) {
  link_ = Link::kOpen;
  wall_ = true;
  const haptic::Caps caps = device_->caps();
  setup_.use_workspace(caps);
  output_.forget_report();
  trouble_.begin(driver_name(), reports_, host);
  device_key_ = device_key(driver_->name, device_->identity().serial);
  session_.rig().servo.set_motor_heat(motor_heat_n2(device_key_, devices::ServoThread::now_s()));
  inherit_stop(device_key_, host);
  if (exchange().motors.request().stopped)
    latch_stop();
  attach();
  apply_settings();
  send_status("open", host);
  send_identity(host);
  if (caps.axes_out == 0)
    send_status("noforce", host);
  models_.warn(stability_limits(), host);
  begin(host);
}

void Phantom::send_identity(Host& host) const {
  if (reports_.on(kStatus))
    send_device(driver_name(), 0, device_->identity(), "open", host);
}

void Phantom::listed(const ListJob::Answer& answer, Host& host) {
  for (const devices::Found& found : answer.found)
    send_device(found.driver, found.index, found.identity, found.state, host);
  for (const auto& [driver, problem] : answer.problems)
    host.info({"obstacle", std::string_view(driver), std::string_view(problem)});
}

/// Reports what is new of a real device's state, faults and troubles.
void Phantom::watch_device(Host& host) {
  if (!open())
    return;
  if (output_.has_report()) {
    trouble_.watch_flags(report().state.flags, reports_, host);
    if (report().faults != faults_) {
      faults_ = report().faults;
      return report().fault == haptic::Fault::kReported ? handle_device_fault(host)
                                                        : handle_lost_device(host);
    }
  }
  if (!trouble_.due(host.now_ms()))
    return;
  const bool still = running_ && output_.silence_s() > kStall_s;
  trouble_.watch(still ? std::string(driver_name()) +
                             ": the servo has stopped: a call of the driver does not return, or "
                             "the driver no longer calls back; close the device, switch it off and "
                             "on, and open it again"
                       : device_->trouble(),
                 driver_name(), reports_, host);
}

/// The device no longer answers: closes it and tries to open it again until it returns.
void Phantom::handle_lost_device(Host& host) {
  const std::string problem = device_->trouble();
  session_.leave_audio();
  link_ = Link::kLost;
  switch_off();
  host.error(std::string(driver_name()) +
             ": the device no longer answers: check its cable and power. It is opened again "
             "when it returns; its motors stay off until motors 1" +
             (problem.empty() ? "" : " (" + problem + ")"));
  if (!problem.empty())
    trouble_.report(problem, driver_name(), reports_, host);
  send_status("lost", host);
  const std::string refusal = worker(host).request({++ticket_, driver_, device_, true});
  replace_rig(host);
  host.wake_in(kWatchWorker, 0);
  if (!refusal.empty())
    closed(refusal, host);
}

/// The device reports a failure but still answers.
void Phantom::handle_device_fault(Host& host) {
  exchange().motors.emergency_stop();
  latch_stop();
  const std::string problem = device_->trouble();
  host.error("the device has failed and its motors stay off until motors 1: " +
             (problem.empty() ? std::string(driver_name()) + ": check the device first" : problem));
  if (!problem.empty())
    trouble_.report(problem, driver_name(), reports_, host);
  reports_.send(kStatus, {"status", "fault", 1.0}, host);
  stop_.report(exchange().motors, reports_, host);
}

/// Also called when the host's program ends without deleting the object.
void Phantom::let_go() noexcept {
  session_.leave_audio();
  if (!driver_) {
    session_.fade_out();
    session_.rig().servo.detach();
  } else if (worker_) {
    exchange().motors.pause(true);
    if (open())
      store_heat();
  }
  worker_.reset(); // its thread closes the device
  lister_.reset();
  link_ = Link::kClosed;
}

} // namespace tactus
