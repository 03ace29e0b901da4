#pragma once

#include "programs/device_options/device_options.hpp"

namespace tactus::haptic_check {

/// The command line of haptic_check.
struct Options {
  bool list = false, yes = false, help = false;
  programs::DeviceOptions device{};
  double seconds = 8; ///< duration of a station
  double rate_hz = 1000;
  std::optional<double> force_n; ///< limit of the force
  std::string report = "haptic_check.txt";
};

using ParsedOptions = programs::Parsed<Options>;
[[nodiscard]] ParsedOptions parse_options(int count, const char* const* words);
[[nodiscard]] const char* usage() noexcept;

} // namespace tactus::haptic_check
