#include "devices/driver.hpp"
#include "devices/evdev/device.hpp"
#include "devices/evdev/joysticks.hpp"

namespace tactus::devices {
namespace {

std::vector<Found> list() {
  std::vector<Found> all;
  for (const evdev::Joystick& one : evdev::joysticks())
    all.push_back({"evdev",
                   static_cast<int>(all.size()),
                   {"", one.name, one.serial},
                   one.allowed ? "ready"
                               : "no permission for " + one.node +
                                     ": install packaging/udev/70-tactus.rules"});
  return all;
}

} // namespace

extern const Driver evdev_driver;
const Driver evdev_driver{
    "evdev", "joysticks and wheels with force feedback, through the kernel",
    [] { return std::string(); }, list,
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<evdev::Device>(); }};

} // namespace tactus::devices
