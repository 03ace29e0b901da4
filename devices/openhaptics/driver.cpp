#include "devices/driver.hpp"
#include "devices/open_devices.hpp"
#include "devices/openhaptics/device.hpp"

#include <filesystem>
#include <fstream>

namespace tactus::devices {
namespace {

std::string problem() {
  openhaptics::HdLibrary library;
  return library.load();
}

/// Whether one of the vendor's USB devices is plugged in. Older devices use FireWire or Ethernet.
bool seen_on_usb() {
  std::error_code failed;
  for (const auto& entry : std::filesystem::directory_iterator("/sys/bus/usb/devices", failed)) {
    std::ifstream file(entry.path() / "idVendor");
    std::string vendor;
    if (file >> vendor && vendor == "2988")
      return true;
  }
  return false;
}

/// The vendor's library cannot list devices without waking them.
std::vector<Found> list() {
  std::vector<Found> known;
  for (Opened& device : open_devices("openhaptics"))
    known.push_back(std::move(device.found));
  if (!known.empty())
    return known;
  if (!problem().empty())
    return {};
  return {{"openhaptics",
           0,
           {"3D Systems", "Default Device", ""},
           seen_on_usb() ? "ready"
                         : "unknown: not seen on USB; open it if it is on FireWire or Ethernet"}};
}

} // namespace

extern const Driver openhaptics_driver;
const Driver openhaptics_driver{
    "openhaptics", "PHANTOM Omni, Desktop, Premium; Touch, Touch X", problem, list,
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<openhaptics::Device>(); }};

} // namespace tactus::devices
