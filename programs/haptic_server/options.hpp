#pragma once

#include "programs/device_options/device_options.hpp"

namespace tactus::haptic_server {

/// The command line of haptic_server.
struct Options {
  programs::DeviceOptions device{"simulated", ""};
  int port = 7770;
  std::string listen, token_file, trace, path, hand = "spring";
  std::optional<double> force_limit_n, stiffness_limit_n_per_m, damping_limit_n_s_per_m;
  double grab_radius_mm = 10, rate_hz = 1000;
  bool once = false, udp = false, help = false;
};

using ParsedOptions = programs::Parsed<Options>;
[[nodiscard]] ParsedOptions parse_options(int count, const char* const* words);
[[nodiscard]] const char* usage() noexcept;

} // namespace tactus::haptic_server
