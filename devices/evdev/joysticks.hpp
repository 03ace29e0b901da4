#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tactus::devices::evdev {

/// An input device that can hold a constant force, found through /sys, so without opening it.
struct Joystick {
  std::string node; ///< such as /dev/input/event3
  std::string name, serial;
  bool allowed = false; ///< this account may read and write the node
};

/// Sorted by the numbers of their nodes.
[[nodiscard]] std::vector<Joystick> joysticks();

/// One bit of a bitmap as /sys writes it: words of a long in hexadecimal, the highest first.
[[nodiscard]] bool bit(std::string_view bitmap, unsigned number) noexcept;

} // namespace tactus::devices::evdev
