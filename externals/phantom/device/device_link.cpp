#include "externals/phantom/device/device_link.hpp"

#include "externals/phantom/device/drivers.hpp"

#include <algorithm>
#include <vector>

namespace tactus::phantom {
namespace {

constexpr double kOverdue_s = 1;     // limit for closing a device or for a cancelled opening
constexpr double kListOverdue_s = 3; // limit for a list of devices

void report_all(const std::vector<std::string>& sentences, Host& host) {
  for (const std::string& sentence : sentences)
    host.error(sentence);
}

void send_list(const ListJob::Answer& list, Host& host) {
  for (const devices::Found& found : list.found)
    send_device(found.driver, found.index, found.identity, found.state, host);
  for (const auto& [driver, problem] : list.problems)
    host.info({"obstacle", std::string_view(driver), std::string_view(problem)});
}

} // namespace

DeviceLink::DeviceLink(ServoSession& session) : session_(session) { add_net_driver(); }

std::string_view DeviceLink::driver_name() const noexcept {
  return is_real() ? driver_->name : "sim";
}

const haptic::Backend& DeviceLink::device() const noexcept {
  if (is_real() && is_open())
    return *device_;
  return simulated;
}

double DeviceLink::period_s() const noexcept {
  if (is_real() && is_open() && device_->owns_thread())
    return 1.0 / std::clamp(device_->caps().rate_hz, 1.0, 1e5);
  return 1.0 / session_.rate_hz;
}

void DeviceLink::choose(const devices::Driver* driver, Device device) noexcept {
  driver_ = driver;
  device_ = std::move(device);
}

std::string DeviceLink::select(Words which) const {
  return which.empty() ? std::string() : phantom::configure(*device_, which, true);
}

void DeviceLink::configure(const Message& row, Words words, Host& host) {
  const bool general = row.name == "driver"; // otherwise the message's name is the setting's name
  if (!is_real())
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

void DeviceLink::list(std::string_view name, Host& host) {
  host.info({"device", "sim", 0.0, "tactus", "simulated", name,
             !is_real() && is_open() ? "open" : "closed"});
  if (devices::drivers().empty())
    return;
  if (!lister_)
    lister_ = std::make_unique<DeviceLister>([&host] { host.wake_from_thread(); });
  if (const std::string late = lister_->overdue(kListOverdue_s); !late.empty())
    return host.error("devices: " + late + " has not returned yet; the list waits for it");
  if (const std::string refusal = lister_->request({}); !refusal.empty())
    host.error("devices: " + refusal);
}

void DeviceLink::send_identity(Host& host) const {
  send_device(driver_name(), 0, device_->identity(), "open", host);
}

void DeviceLink::attach() noexcept {
  session_.rig().set_limits(device().caps());
  if (is_real())
    session_.attach(device_);
  else
    session_.attach(simulated);
}

std::string DeviceLink::request(const DeviceJob::Request& request, Host& host) {
  if (!worker_)
    worker_ = std::make_unique<DeviceWorker>([&host] { host.wake_from_thread(); });
  return worker_->request(request);
}

std::string DeviceLink::request_open(Host& host, bool persists) {
  runs_ = false;
  return request({++ticket_, driver_, device_, persists}, host);
}

std::string DeviceLink::request_run(Host& host) {
  return request(
      {ticket_, driver_, device_, false, {session_.shared_rig(), session_.thread()}, period_s()},
      host);
}

std::string DeviceLink::request_close(Host& host) {
  runs_ = false;
  return request({++ticket_}, host);
}

std::optional<DeviceJob::Answer> DeviceLink::take(Host& host) {
  if (lister_) {
    const auto taken = lister_->take();
    report_all(taken.sentences, host);
    if (taken.answer)
      send_list(*taken.answer, host);
  }
  if (!worker_)
    return {};
  auto taken = worker_->take();
  report_all(taken.sentences, host);
  if (!taken.answer || taken.answer->ticket != ticket_)
    return {}; // the answer is about a device that is no longer requested
  if (taken.answer->kind == DeviceJob::Answer::Kind::kRunning) {
    runs_ = true;
    session_.thread()->set_period(period_s()); // the rate may have changed since the request
  }
  return std::move(taken.answer);
}

void DeviceLink::change_rate() noexcept {
  if (runs_ && !device_->owns_thread())
    session_.thread()->set_period(period_s());
}

std::string DeviceLink::abandon_overdue() {
  if (!worker_)
    return {};
  worker_->cancel_unwanted();
  std::string late = worker_->overdue(kOverdue_s);
  if (!late.empty()) {
    worker_.reset();
    runs_ = false;
  }
  return late;
}

void DeviceLink::let_go() noexcept {
  worker_.reset();
  lister_.reset();
  state = State::kClosed;
}

} // namespace tactus::phantom
