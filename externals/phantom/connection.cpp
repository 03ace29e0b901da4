#include "core/declaration_text.hpp"
#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/motor_heat.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/signal_link_name.hpp"
#include "externals/phantom/tags.hpp"

/// Choosing, opening and closing [phantom]'s device. A worker opens, runs and closes real devices,
/// since a call of a driver may take seconds or never return. The host's thread waits for none of
/// these calls and reads the answers in posted().
namespace tactus {

using namespace phantom;
using Answer = DeviceWorker::Answer;

namespace {

constexpr double kWatchInterval_ms = 50;
constexpr double kOverdue_s = 1;     // for closing a device, or for an opening that was cancelled
constexpr double kListOverdue_s = 3; // for a list

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

/// "evdev, falcon or net"; the list may begin with "sim", the simulated device.
std::string driver_names(bool with_simulation) {
  std::vector<std::string_view> all;
  if (with_simulation)
    all.emplace_back("sim");
  for (const devices::Driver* driver : devices::drivers())
    all.emplace_back(driver->name);
  std::string names;
  for (std::size_t i = 0; i < all.size(); ++i)
    names += (i == 0 ? "" : i + 1 == all.size() ? " or " : ", ") + std::string(all[i]);
  return names;
}

} // namespace

const haptic::Backend& Phantom::device() const noexcept {
  if (driver_ && open())
    return *device_;
  return simulated_;
}

std::string_view Phantom::driver_name() const noexcept { return driver_ ? driver_->name : "sim"; }

DeviceWorker& Phantom::worker(Host& host) {
  if (!worker_)
    worker_ = std::make_unique<DeviceWorker>([&host] { host.wake_from_thread(); });
  return *worker_;
}

void Phantom::send_status(std::string_view word, Host& host) const {
  if (reported_[kStatus])
    host.info({"status", word, driver_name()});
}

bool Phantom::for_simulation(std::string_view message, Host& host) const {
  if (!driver_)
    return true;
  host.error(std::string(message) + ": only for the simulated device, not for " +
             std::string(driver_name()) + "; send backend sim first");
  return false;
}

void Phantom::on_backend(Words words, Host& host) {
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

/// Passes words to the device's driver as a setting; with `which` as the choice of a device.
std::string Phantom::configure(haptic::Backend& device, Words words, bool which) {
  std::vector<std::string> texts;
  if (which)
    texts.emplace_back("device");
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  return device.configure(texts);
}

/// Words after a driver's name are a setting, as after `driver`, or say which device.
std::string Phantom::configure_new(haptic::Backend& device, Words words) {
  if (words.size() > 1 && configure(device, words, false).empty())
    return {};
  return configure(device, words, true);
}

void Phantom::on_setting(Words words, Host& host, std::string_view name) {
  if (!driver_)
    return host.error((name.empty() ? "driver" : std::string(name)) +
                      ": only for a real device; first choose one with backend " +
                      driver_names(false));
  std::vector<std::string> texts;
  if (!name.empty())
    texts.emplace_back(name);
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  std::string asked = name.empty() ? "driver" : "";
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

void Phantom::on_devices(Host& host) {
  host.info({"device", "sim", 0.0, "tactus", "simulated", std::string_view(name_),
             !driver_ && open() ? "open" : "closed"});
  if (devices::drivers().empty())
    return;
  if (!lister_)
    lister_ = std::make_unique<DeviceWorker>([&host] { host.wake_from_thread(); });
  if (const std::string late = lister_->overdue(kListOverdue_s); !late.empty())
    return host.error("devices: " + late + " has not returned yet; the list waits for it");
  if (const std::string refusal = lister_->list(); !refusal.empty())
    host.error("devices: " + refusal);
}

void Phantom::on_name(Words words, Host& host) {
  if (signals_published_)
    host.publish(signal_link_name(name_), nullptr);
  name_ = text_of(words[0]);
  signals_published_ = created_ && host.publish(signal_link_name(name_), rig_->signals);
  if (!created_)
    return; // creation does the rest
  if (!signals_published_)
    host.error("name " + name_ + ": another phantom has this name; phantom~ connects to that one");
  if (exchange().motors.request().stopped)
    latch_stop();
  inherit_stop(name_key(name_), host);
}

void Phantom::connect_simulation(Host& host) {
  if (const std::string refusal = simulated_.open(); !refusal.empty())
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
  if (const std::string refusal = worker(host).open(*driver_, device_, ++ticket_); !refusal.empty())
    return closed("open: " + refusal, host);
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

void Phantom::disconnect(Host& host) {
  if (link_ == Link::kClosed)
    return;
  if (driver_) {
    end_session(host);
  } else {
    fade_out();
    rig_->servo.detach();
    rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {});
    static_cast<void>(simulated_.write({}));
    simulated_.close();
  }
  closed({}, host);
}

/// Gives the real device and its servo to the worker, which lets the force fall and closes the
/// device. The object continues with a new servo.
void Phantom::end_session(Host& host) {
  worker_->abandon();
  while (const auto answer = worker_->take())
    if (answer->kind == Answer::Kind::kOpened)
      static_cast<void>(worker_->close(driver_, {}, answer->device)); // its thread is there
  if (open()) {
    collect(host);
    if (!open())
      return; // collect() found the device lost
    rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {});
    exchange().motors.pause(true);
    if (const std::string refusal = worker_->close(driver_, {rig_, runner_}, device_);
        !refusal.empty())
      host.error("close: " + refusal);
    replace_rig(host);
  }
  host.wake_in(kWatchWorker, kWatchInterval_ms);
}

/// The device is closed; reports that and the reason, if any.
void Phantom::closed(std::string_view why, Host& host) {
  link_ = Link::kClosed;
  has_report_ = has_report_ && !driver_;
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
/// thread that ends it; its last report is copied.
void Phantom::replace_rig(Host& host) {
  auto next = std::make_shared<ServoRig>();
  haptic::Exchange& from = exchange();
  haptic::Exchange& to = next->servo.exchange();
  to.motors.take_over(from.motors);
  to.tracing = from.tracing.load();
  from.tracing = false;
  store_heat();
  from.statistics.read();
  to.reports.write(from.reports.latest());
  to.reports.read();
  to.statistics.write(from.statistics.latest());
  to.statistics.read();
  next->servo.continue_statistics(from.reports.latest(), from.statistics.latest());
  to.wrist.write(wrist_);
  next->scene.publish(scene_.snapshot());
  next->network.publish(network_.snapshot());
  next->effects.set(effect_settings_);
  if (signals_published_) {
    host.publish(signal_link_name(name_), nullptr);
    signals_published_ = host.publish(signal_link_name(name_), next->signals);
  }
  rig_ = std::move(next);
  runner_ = std::make_shared<devices::ServoThread>();
  running_ = false;
  faults_ = 0;
  lost_reported_ = 0;
  audio_blocks_ = 0;
  apply_settings();
}

void Phantom::posted(Host& host) {
  while (const auto answer = lister_ ? lister_->take() : std::nullopt)
    listed(*answer, host);
  while (const auto answer = worker_ ? worker_->take() : std::nullopt) {
    const bool current = answer->ticket == ticket_;
    switch (answer->kind) {
    case Answer::Kind::kListed:
      break;
    case Answer::Kind::kOpened:
      opened(*answer, host);
      break;
    case Answer::Kind::kRefused:
      if (!current || link_ != Link::kOpening)
        break;
      send_trouble(answer->sentence, host);
      closed(answer->sentence, host);
      break;
    case Answer::Kind::kRunning:
      running_ = current && open();
      report_s_ = devices::ServoThread::now_s();
      if (running_)
        runner_->set_period(period_s());
      break;
    case Answer::Kind::kNotRunning:
      if (!current || !open())
        break;
      send_trouble(answer->sentence, host);
      host.error(std::string(driver_name()) + ": " + answer->sentence);
      disconnect(host);
      break;
    case Answer::Kind::kTrouble:
      if (current && link_ == Link::kLost)
        send_trouble(trouble_ = answer->sentence, host);
      break;
    case Answer::Kind::kClosed:
      if (!answer->released)
        host.error("close: the device did not accept the final zero force; it may be unplugged");
      break;
    }
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
  worker_.reset(); // the thread owns its data and ends when the call returns
  host.error(late + " has not returned for 1 s; its thread is abandoned. Switch the device off "
                    "and on; if it cannot be opened then, restart the host");
  if (again) { // the new opening was queued behind that call
    if (const std::string refusal = worker(host).open(*driver_, device_, ++ticket_);
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

void Phantom::opened(const Answer& answer, Host& host) {
  if (answer.ticket != ticket_ || (link_ != Link::kOpening && link_ != Link::kLost)) {
    static_cast<void>(worker_->close(driver_, {}, answer.device)); // its thread is there
    return;
  }
  link_ = Link::kOpen;
  wall_ = true;
  const haptic::Caps caps = device_->caps();
  if (!own_workspace_)
    settings_.chain.workspace = {caps.workspace_min, caps.workspace_max};
  has_report_ = false;
  flags_.reset();
  if (!trouble_.empty())
    send_trouble(trouble_ = {}, host);
  driver_trouble_.clear();
  device_key_ = device_key(driver_->name, device_->identity().serial);
  rig_->servo.set_motor_heat(motor_heat_n2(device_key_, devices::ServoThread::now_s()));
  inherit_stop(device_key_, host);
  if (exchange().motors.request().stopped)
    latch_stop();
  attach();
  apply_settings();
  send_status("open", host);
  send_identity(host);
  if (caps.axes_out == 0)
    send_status("noforce", host);
  warn_of_scene(host); // now that the device's limits are known
  for (const char* effect : {"spring", "viscous", "inertia", "friction", "texture"})
    warn_of_effect(effect, host);
  begin(host);
}

void Phantom::send_identity(Host& host) const {
  const haptic::Identity identity = device_->identity();
  const auto word = [](const std::string& text) { return text.empty() ? "-" : text; };
  const std::string vendor = word(identity.vendor), model = word(identity.model),
                    serial = word(identity.serial);
  if (reported_[kStatus])
    host.info({"device", driver_name(), 0.0, std::string_view(vendor), std::string_view(model),
               std::string_view(serial), "open"});
}

void Phantom::listed(const Answer& answer, Host& host) {
  const auto word = [](const std::string& text) { return text.empty() ? "-" : text; };
  for (const devices::Found& found : answer.found) {
    const std::string vendor = word(found.identity.vendor), model = word(found.identity.model),
                      serial = word(found.identity.serial), state = word(found.state);
    host.info({"device", found.driver, static_cast<double>(found.index), std::string_view(vendor),
               std::string_view(model), std::string_view(serial), std::string_view(state)});
  }
  for (const auto& [driver, problem] : answer.problems)
    host.info({"obstacle", std::string_view(driver), std::string_view(problem)});
}

/// Also called when the host's program ends without deleting the object.
void Phantom::let_go() noexcept {
  rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {});
  if (!driver_) {
    fade_out();
    rig_->servo.detach();
  } else if (worker_) {
    worker_->abandon();
    exchange().motors.pause(true);
    if (open()) {
      store_heat();
      static_cast<void>(worker_->close(driver_, {rig_, runner_}, device_));
    }
  }
  link_ = Link::kClosed;
}

} // namespace tactus
