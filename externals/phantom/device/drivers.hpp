#pragma once

#include "devices/driver.hpp"
#include "externals/phantom/words.hpp"

#include <memory>
#include <string>
#include <string_view>

namespace tactus::phantom {

/// Registers the driver `net`, a device behind a server of the haptic protocol. Does nothing in a
/// build without sockets.
void add_net_driver() noexcept;

/// "evdev, falcon or net"; the list may begin with "sim", the simulated device.
[[nodiscard]] std::string driver_names(bool with_simulation);
/// The driver that the words after `backend` name, and a device with their settings.
struct DriverChoice {
  const devices::Driver* driver = nullptr; ///< null: the simulated device
  std::shared_ptr<haptic::Backend> device{};
  std::string refusal{};
};
[[nodiscard]] DriverChoice choose_driver(Words words);

/// Passes words to a device's driver as a setting; with `which` as the choice of a device. Returns
/// a sentence when they are refused.
[[nodiscard]] std::string configure(haptic::Backend& device, Words words, bool which);
/// Sends what a driver says of a device; `-` where it says nothing.
void send_device(std::string_view driver, int index, const haptic::Identity& identity,
                 std::string_view state, Host& host);

} // namespace tactus::phantom
