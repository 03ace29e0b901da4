#include "devices/driver.hpp"
#include "devices/force_dimension/device.hpp"

namespace tactus::devices {
namespace {

std::string problem() {
  force_dimension::DhdLibrary library;
  return library.load();
}

/// Counts the devices without opening them. While a device is open, this function does not call the
/// library. The list then contains only open devices; others appear once these are closed.
std::vector<Found> list() {
  std::vector<Found> all;
  for (Opened& device : open_devices("dhd"))
    all.push_back(std::move(device.found));
  if (!all.empty())
    return all;
  force_dimension::DhdLibrary library;
  if (!library.load().empty())
    return all;
  const int count = library.device_count();
  for (int i = 0; i < count; ++i)
    all.push_back({"dhd", i, {"Force Dimension", "haptic device", ""}, "ready"});
  return all;
}

} // namespace

extern const Driver dhd_driver;
const Driver dhd_driver{"dhd", "Force Dimension omega, delta, sigma, lambda", problem, list,
                        []() -> std::unique_ptr<haptic::Backend> {
                          return std::make_unique<force_dimension::Device>();
                        }};

} // namespace tactus::devices
