#pragma once

#include "core/haptic/device/device.hpp"
#include "core/text.hpp"

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::programs {

/// The device that a program opens, and its settings.
struct DeviceOptions {
  std::string driver, which;                        ///< --device DRIVER[:WHICH]
  std::vector<std::vector<std::string>> settings{}; ///< one for each --set "WORD VALUE..."
};

/// Applies the settings to the device, then its WHICH. Returns an empty text, or the device's first
/// refusal.
[[nodiscard]] std::string configure(haptic::Backend& device, const DeviceOptions& options);

/// The options of a command line, or one sentence.
template <class Options> struct Parsed {
  Options options;
  std::string error;
};

/// The line of the usage text about an option, such as "0..65535; 0: any free port (7770)". Empty
/// if no line begins with two spaces and the option.
[[nodiscard]] std::string option_text(std::string_view usage, std::string_view name);

/// An option without a value.
struct Flag {
  std::string_view name;
  bool* set;
};
/// Sets an option's value; returns false if the value is not valid.
using SetOption = std::function<bool(std::string_view name, const std::string& value)>;

/// Reads a command line, whose first word is the program: flags (-h counts as --help), options of
/// the device, and the options that the usage text names, which it passes to `set`. Returns an
/// empty text, or one sentence.
[[nodiscard]] std::string read_options(std::span<const char* const> words, std::string_view usage,
                                       std::span<const Flag> flags, DeviceOptions& device,
                                       const SetOption& set);

/// Reads a number within a range into `target`; returns false if the text is not such a number.
template <class Target>
[[nodiscard]] bool read(std::string_view text, double low, double high, Target& target) {
  const auto value = to_number(text, low, high);
  if (value)
    target = *value;
  return value.has_value();
}

} // namespace tactus::programs
