#include "devices/falcon/falcon.hpp"

#include <algorithm>

namespace tactus::devices {
namespace {

std::string problem() {
  falcon::UsbLibrary usb;
  return usb.load();
}

std::vector<Found> list() {
  std::vector<Found> found;
  falcon::UsbLibrary usb;
  if (!usb.load().empty())
    return found;
  const std::vector<Opened> opened = open_devices("falcon");
  const auto find_open = [&](const std::string& path) {
    return std::find_if(opened.begin(), opened.end(),
                        [&](const Opened& device) { return device.address == path; });
  };
  const auto is_open = [&](const std::string& path) { return find_open(path) != opened.end(); };
  for (const falcon::Port& port : falcon::Link::ports(usb, is_open)) {
    const int index = static_cast<int>(found.size());
    if (const auto device = find_open(port.path); device != opened.end()) {
      found.push_back(device->found);
      found.back().index = index;
      continue;
    }
    found.push_back({"falcon",
                     index,
                     {"Novint", "Falcon", port.serial.empty() ? port.path : port.serial},
                     port.problem.empty() ? "ready" : port.problem});
  }
  return found;
}

std::unique_ptr<haptic::Backend> make() { return std::make_unique<falcon::Falcon>(); }

} // namespace

extern const Driver falcon_driver;
const Driver falcon_driver{"falcon", "Novint Falcon", problem, list, make};

} // namespace tactus::devices
