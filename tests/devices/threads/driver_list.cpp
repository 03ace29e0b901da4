#include "devices/driver.hpp"

#include <array>

// The drivers whose threads are watched here; the build's own list would bring all of them.
namespace tactus::devices {

extern const Driver openhaptics_driver, haply_driver;
namespace {
const std::array<const Driver*, 2> kDrivers{&openhaptics_driver, &haply_driver};
}

std::span<const Driver* const> drivers() noexcept { return kDrivers; }

const Driver* find_driver(std::string_view name) noexcept {
  for (const Driver* driver : kDrivers)
    if (driver->name == name)
      return driver;
  return nullptr;
}

} // namespace tactus::devices
