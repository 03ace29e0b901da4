#include "devices/falcon/falcon.hpp"

#include <algorithm>

namespace tactus::devices {
namespace {

std::string obstacle() {
  falcon::UsbLibrary usb;
  return usb.load();
}

std::vector<Found> list() {
  std::vector<Found> found;
  falcon::UsbLibrary usb;
  if (!usb.load().empty())
    return found;
  const std::vector<Opened> opened = open_devices("falcon");
  const auto known = [&](const std::string& path) {
    return std::find_if(opened.begin(), opened.end(),
                        [&](const Opened& device) { return device.address == path; });
  };
  const auto is_open = [&](const std::string& path) { return known(path) != opened.end(); };
  for (const falcon::Port& port : falcon::Link::ports(usb, is_open)) {
    const int index = static_cast<int>(found.size());
    if (const auto device = known(port.path); device != opened.end()) {
      found.push_back(device->found);
      found.back().index = index;
      continue;
    }
    found.push_back({"falcon",
                     index,
                     {"Novint", "Falcon", port.serial.empty() ? port.path : port.serial},
                     port.obstacle.empty() ? "ready" : port.obstacle});
  }
  return found;
}

std::unique_ptr<haptic::Backend> make() { return std::make_unique<falcon::Falcon>(); }

} // namespace

extern const Driver falcon_driver;
const Driver falcon_driver{"falcon", "Novint Falcon", obstacle, list, make};

} // namespace tactus::devices
