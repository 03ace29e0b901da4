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

/// The names of the drivers as a text, such as "evdev, falcon or net", with "sim" for the simulated
/// device if requested.
[[nodiscard]] std::string driver_names(bool with_simulation);
/// The driver that the words after `backend` name, and a device with the settings in these words.
struct DriverChoice {
  const devices::Driver* driver = nullptr; ///< null for the simulated device
  std::shared_ptr<haptic::Backend> device{};
  std::string refusal{};
};
[[nodiscard]] DriverChoice choose_driver(Words words);

/// Passes words to a device's driver as a setting; with `which` as the choice of a device. Returns
/// a sentence if the words are refused.
[[nodiscard]] std::string configure(haptic::Backend& device, Words words, bool which);
/// Sends a driver's description of a device, with `-` for missing parts.
void send_device(std::string_view driver, int index, const haptic::Identity& identity,
                 std::string_view state, Host& host);

} // namespace tactus::phantom
