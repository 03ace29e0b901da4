#include "devices/driver.hpp"
#include "devices/haply/device.hpp"
#include "devices/haply/socket.hpp"

namespace tactus::devices {
namespace {

constexpr double kProbeTimeout_s = 0.3;

/// The service's first message, or nothing.
std::optional<haply::Message> inventory(std::string& failure) {
  const std::atomic<bool> never{false};
  const haply::Address address = haply::default_address();
  haply::Socket socket(never);
  std::string text;
  failure = socket.connect(address.host, address.port, kProbeTimeout_s);
  if (failure.empty())
    failure = socket.receive(text, kProbeTimeout_s);
  socket.close();
  if (!failure.empty()) {
    failure = "Haply's service does not answer on " + address.host + ":" + address.port + " (" +
              failure +
              "): install Haply Hub or the inverse service from docs.haply.co, start it, "
              "or send service HOST PORT";
    return {};
  }
  auto message = haply::parse(text);
  if (!message)
    failure = "the program on " + address.host + ":" + address.port + " is not Haply's service";
  return message;
}

std::string problem() {
  std::string failure;
  static_cast<void>(inventory(failure));
  return failure;
}

std::vector<Found> list() {
  std::string failure;
  std::vector<Found> all;
  if (const auto message = inventory(failure))
    for (const haply::DeviceState& one : message->devices)
      all.push_back({"haply",
                     static_cast<int>(all.size()),
                     {"Haply", one.type.empty() ? "inverse3" : one.type, one.id},
                     one.calibrated.value_or(false) ? "ready" : "not calibrated"});
  return all;
}

} // namespace

extern const Driver haply_driver;
const Driver haply_driver{
    "haply", "Haply Inverse3, Inverse3x, Minverse, through Haply's service", problem, list,
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<haply::Device>(); }};

} // namespace tactus::devices
