#include "programs/haptic_server/options.hpp"

#include <string_view>

namespace tactus::haptic_server {
namespace {

/// Sets one option; returns false if its value is not valid.
bool set(std::string_view name, const std::string& value, Options& o) {
  using programs::read;
  if (name == "--port") {
    const auto port = to_number(value, 0, 65535);
    o.port = port.value_or(o.port);
    return port.has_value();
  }
  if (name == "--hand")
    return o.hand = value,
           value == "free" || value == "rigid" || value == "spring" || value == "person";
  if (name == "--listen")
    return o.listen = value, true;
  if (name == "--token")
    return o.token_file = value, true;
  if (name == "--trace")
    return o.trace = value, true;
  if (name == "--path")
    return o.path = value, true;
  if (name == "--force-limit")
    return read(value, 0.01, 40, o.force_limit_n);
  if (name == "--stiffness-limit")
    return read(value, 0, 20000, o.stiffness_limit_n_per_m);
  if (name == "--damping-limit")
    return read(value, 0, 1000, o.damping_limit_n_s_per_m);
  if (name == "--grab-radius")
    return read(value, 0, 1000, o.grab_radius_mm);
  return name == "--rate" && read(value, 200, 4000, o.rate_hz);
}

} // namespace

const char* usage() noexcept {
  return "haptic_server [--device DRIVER[:WHICH]] [--set \"NAME VALUE\"]... [--port N]\n"
         "              [--listen ADDRESS --token FILE] [--udp] [--force-limit N] [--once] ...\n"
         "\n"
         "Serves a haptic device to clients on this machine, or on others: "
         "docs/haptic_network.md.\n"
         "\n"
         "  --device           sim, falcon, hid, openhaptics, dhd, haply or evdev; WHICH is an "
         "index, a\n"
         "                     serial number or a path (sim)\n"
         "  --set              a setting of the device, as for [phantom]: --set \"peak 3\"\n"
         "  --port             0..65535; 0: any free port (7770)\n"
         "  --listen           a numeric address to accept clients on (loopback); others need "
         "--token\n"
         "  --token            a file of 16 to 1024 bytes that every client must send\n"
         "  --udp              send positions as datagrams to clients that ask for them\n"
         "  --force-limit      0.01..40 N, which no client can raise (8, or the device's peak)\n"
         "  --stiffness-limit  0..20000 N/m for a client's spring (0.6 of the device's, or 500)\n"
         "  --damping-limit    0..1000 N s/m for a client's damper (the device's, or 5)\n"
         "  --grab-radius      0..1000 mm between the handle and a control point that it can drag "
         "(10)\n"
         "  --rate             200..4000 ticks a second (1000)\n"
         "  --trace            a CSV file with one row for each tick: position, velocity, force\n"
         "  --once             exit when the last client has disconnected\n"
         "  --path             a file of rows `ms x y z [buttons]`, mm, for the simulated hand of "
         "sim\n"
         "  --hand             free, rigid, spring or person: how the hand holds sim (spring)\n"
         "\n"
         "SIGINT and SIGTERM switch the force off and exit. SIGUSR1 is an emergency stop, which no "
         "client\n"
         "can release; SIGUSR2 releases it, and the motors stay off until a client sends start.\n";
}

ParsedOptions parse_options(int count, const char* const* words) {
  Options o;
  const programs::Flag flags[] = {{"--once", &o.once}, {"--udp", &o.udp}, {"--help", &o.help}};
  std::string error = programs::read_options(
      std::span(words, static_cast<std::size_t>(count)), usage(), flags, o.device,
      [&o](std::string_view name, const std::string& value) { return set(name, value, o); });
  return {o, error};
}

} // namespace tactus::haptic_server
