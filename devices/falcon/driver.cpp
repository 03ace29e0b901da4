#include "devices/falcon/falcon.hpp"

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
  for (const falcon::Port& port : falcon::Link::ports(usb)) {
    const int index = static_cast<int>(found.size());
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
