#include "core/words.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/signal_link_name.hpp"
#include "externals/phantom/tags.hpp"

/// Which device [phantom] has, and how it comes and goes. Real devices are opened and closed by a
/// worker, since that may take seconds; the host's thread takes its answers in posted().
namespace tactus {

using namespace phantom;
using Answer = DeviceWorker::Answer;

namespace {

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::string known_drivers() {
  std::string names = "sim";
  const auto all = devices::drivers();
  for (std::size_t i = 0; i < all.size(); ++i)
    names += (i + 1 == all.size() ? " or " : ", ") + std::string(all[i]->name);
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
  host.error(std::string(message) + ": only the simulated device has one, not " +
             std::string(driver_name()) + "; send backend sim first");
  return false;
}

void Phantom::on_backend(Words words, Host& host) {
  const devices::Driver* wanted = nullptr;
  if (!is(words[0], "sim")) {
    wanted = words[0].is_word ? devices::find_driver(words[0].word) : nullptr;
    if (!wanted)
      return host.error(expected("backend", words[0], known_drivers()));
  } else if (words.size() > 1) {
    return host.error("backend sim: takes no arguments");
  }
  Device made;
  if (wanted) {
    made = wanted->make();
    if (!made)
      return host.error("backend " + std::string(wanted->name) + ": " + wanted->obstacle());
    if (words.size() > 1)
      if (const std::string refusal = configure(*made, words.subspan(1), words.size() == 2);
          !refusal.empty())
        return host.error("backend " + refusal);
  } else if (!driver_) {
    if (created_ && !open())
      connect_simulation(host);
    return;
  }
  disconnect(host);
  driver_ = wanted;
  device_ = std::move(made);
  if (!driver_ && created_)
    connect_simulation(host);
}

/// Hands words to the device's driver; one word alone says which device, if it names none.
std::string Phantom::configure(haptic::Backend& device, Words words, bool which) {
  std::vector<std::string> texts;
  if (which)
    texts.emplace_back("device");
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  return device.configure(texts);
}

void Phantom::on_setting(Words words, Host& host, std::string_view name) {
  if (!driver_)
    return host.error((name.empty() ? "driver" : std::string(name)) +
                      ": only a real device has one; choose it first with backend " +
                      known_drivers());
  std::vector<std::string> texts;
  if (!name.empty())
    texts.emplace_back(name);
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  if ((texts[0] == "firmware" || texts[0] == "table") && texts.size() == 2) {
    std::string found = host.find_file(texts[1]);
    if (found.empty())
      return host.error(texts[0] + " " + texts[1] +
                        ": no such file beside the patch or in Pd's search path");
    texts[1] = std::move(found);
  }
  if (const std::string refusal = device_->configure(texts); !refusal.empty())
    host.error(refusal);
}

void Phantom::on_devices(Host& host) {
  host.info({"device", "sim", 0.0, "tactus", "simulated", std::string_view(name_),
             !driver_ && open() ? "open" : "closed"});
  if (!devices::drivers().empty())
    worker(host).list();
}

void Phantom::on_name(Words words, Host& host) {
  if (offered_)
    host.offer(signal_link_name(name_), nullptr);
  name_ = text_of(words[0]);
  offered_ = created_ && host.offer(signal_link_name(name_), signals_);
  if (created_ && !offered_)
    host.error("name " + name_ + ": another phantom has it; phantom~ finds that one");
}

void Phantom::connect_simulation(Host& host) {
  if (const std::string refusal = simulated_.open(); !refusal.empty())
    return host.error(refusal);
  link_ = Link::kOpen;
  wall_ = clock_ == Clock::kWall;
  attach();
  settle();
  begin(host);
  send_status("open", host);
}

void Phantom::connect(Words which, Host& host) {
  if (!driver_) {
    if (!created_)
      return; // creation opens it
    disconnect(host);
    return connect_simulation(host);
  }
  if (clock_ == Clock::kLogical)
    return host.error("open: a real device cannot be stepped by the patch's time; send clock auto "
                      "or clock wall first");
  if (clock_ == Clock::kAuto && !host.real_time())
    return host.error("open: this is a render in batch, faster or slower than a real device; send "
                      "clock wall first to use it all the same");
  disconnect(host);
  if (!which.empty())
    if (const std::string refusal = configure(*device_, which, true); !refusal.empty())
      return host.error(refusal);
  link_ = Link::kOpening;
  send_status("opening", host);
  worker(host).open(*driver_, device_, ++ticket_);
}

void Phantom::disconnect(Host& host) {
  if (link_ == Link::kClosed)
    return;
  const bool was_open = open();
  fade_out();
  servo_.detach();
  signals_->place(haptic::SignalLink::Time::kNone, 0, {});
  if (!driver_) {
    static_cast<void>(simulated_.write({}));
    simulated_.close();
  } else {
    if (was_open && !device_->write({}))
      host.error("close: the device did not take the last force, zero; it may be unplugged");
    worker_->forget();
    if (was_open)
      worker_->close(device_);
    while (const auto answer = worker_->take())
      if (answer->kind == Answer::Kind::kOpened)
        worker_->close(answer->device);
      else if (answer->kind == Answer::Kind::kListed)
        listed(*answer, host);
  }
  link_ = Link::kClosed;
  has_report_ = has_report_ && !driver_;
  send_status("closed", host);
}

void Phantom::posted(Host& host) {
  if (!worker_)
    return;
  while (const auto answer = worker_->take())
    switch (answer->kind) {
    case Answer::Kind::kListed:
      listed(*answer, host);
      break;
    case Answer::Kind::kOpened:
      opened(*answer, host);
      break;
    case Answer::Kind::kRefused:
      if (answer->ticket != ticket_ || link_ != Link::kOpening)
        break;
      link_ = Link::kClosed;
      host.error(answer->refusal);
      send_status("closed", host);
      break;
    }
}

void Phantom::opened(const Answer& answer, Host& host) {
  if (answer.ticket != ticket_ || (link_ != Link::kOpening && link_ != Link::kLost))
    return worker_->close(answer.device);
  link_ = Link::kOpen;
  wall_ = true;
  guard_termination();
  const haptic::Caps caps = device_->caps();
  if (!own_workspace_)
    settings_.chain.workspace = {caps.workspace_min, caps.workspace_max};
  servo_.exchange().reports.read(); // the last device's
  has_report_ = false;
  flags_ = haptic::State::kHomed;
  attach();
  settle();
  send_status("open", host);
  send_identity(host);
  if (caps.axes_out == 0)
    send_status("noforce", host);
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
  for (const auto& [driver, obstacle] : answer.obstacles)
    host.info({"obstacle", std::string_view(driver), std::string_view(obstacle)});
}

/// The device does not answer any more: it is closed and looked for until it returns.
void Phantom::lose(Host& host) {
  if (!driver_ || !open())
    return;
  runner_.stop();
  servo_.detach();
  signals_->place(haptic::SignalLink::Time::kNone, 0, {});
  link_ = Link::kLost;
  values_[kMotors] = 0;
  host.error(std::string(driver_name()) +
             ": the device does not answer any more; check its cable and power. It is opened again "
             "when it returns, with its motors off until motors 1");
  send_status("lost", host);
  worker(host).reopen(*driver_, device_, ++ticket_);
}

/// What the device says of itself, when it changes.
void Phantom::watch_flags(Host& host) {
  if (!driver_ || !has_report_ || !open())
    return;
  using haptic::State;
  const std::uint32_t now = servo_.exchange().reports.latest().state.flags;
  const std::uint32_t changed = now ^ flags_;
  flags_ = now;
  constexpr std::pair<std::uint32_t, std::string_view> kWatched[] = {
      {State::kHomed, "homed"}, {State::kMotorsHot, "hot"}, {State::kForceLimited, "limited"}};
  for (const auto& [flag, word] : kWatched)
    if ((changed & flag) && reported_[kStatus])
      host.info({"status", word, (now & flag) ? 1.0 : 0.0});
}

/// Also when the host's program ends without deleting the object.
void Phantom::let_go() noexcept {
  fade_out();
  servo_.detach();
  if (driver_ && open()) {
    static_cast<void>(device_->write({}));
    device_->close();
  }
  link_ = Link::kClosed;
  if (worker_)
    worker_->finish();
}

void Phantom::stop_now() noexcept {
  servo_.exchange().actions.push(haptic::Action::kEmergencyStop);
}

bool Phantom::stopped() noexcept {
  servo_.exchange().reports.read();
  const haptic::Report& report = servo_.exchange().reports.latest();
  return !runner_.running() || (report.latched && norm(report.force_n) == 0.0);
}

} // namespace tactus
