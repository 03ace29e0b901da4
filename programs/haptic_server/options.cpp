#include "programs/haptic_server/options.hpp"

#include <string_view>

namespace tactus::haptic_server {
namespace {

/// One option with its value; false when the value is not understood.
bool set(const std::string& name, const std::string& value, Options& options) {
  const auto real = [&](double min, double max, auto& target) {
    const auto parsed = programs::number_of(value, min, max);
    if (parsed)
      target = *parsed;
    return parsed.has_value();
  };
  if (const auto taken = programs::set_device_option(name, value, options.device))
    return *taken;
  if (name == "--port") {
    double port = 0;
    if (!real(0, 65535, port) || port != static_cast<int>(port))
      return false;
    options.port = static_cast<int>(port);
    return true;
  }
  if (name == "--hand")
    return options.hand = value,
           value == "free" || value == "rigid" || value == "spring" || value == "person";
  if (name == "--listen")
    return options.listen = value, true;
  if (name == "--token")
    return options.token_file = value, true;
  if (name == "--trace")
    return options.trace = value, true;
  if (name == "--path")
    return options.path = value, true;
  if (name == "--force-limit")
    return real(0.01, 40, options.force_limit_n);
  if (name == "--stiffness-limit")
    return real(0, 20000, options.stiffness_limit_n_per_m);
  if (name == "--damping-limit")
    return real(0, 1000, options.damping_limit_n_s_per_m);
  if (name == "--grab-radius")
    return real(0, 1000, options.grab_radius_mm);
  return name == "--rate" && real(200, 4000, options.rate_hz);
}

constexpr std::string_view kWithValue[] = {
    "--device",          "--set",           "--port",       "--listen", "--token",
    "--force-limit",     "--rate",          "--trace",      "--path",   "--hand",
    "--stiffness-limit", "--damping-limit", "--grab-radius"};

} // namespace

const char* usage() noexcept {
  return "haptic_server [--device DRIVER[:WHICH]] [--set \"NAME VALUE\"]... [--port N]\n"
         "              [--listen ADDRESS --token FILE] [--udp] [--force-limit N] [--once] ...\n"
         "\n"
         "Serves a haptic device to clients on this machine, or on others: "
         "docs/haptic_network.md.\n"
         "\n"
         "  --device           sim, falcon, hid, openhaptics, dhd, haply, evdev; WHICH is an "
         "index, a\n"
         "                     serial number or a path (sim)\n"
         "  --set              one setting of the device, as [phantom] takes it: --set \"peak 3\"\n"
         "  --port             0..65535; 0 takes one that is free (7770)\n"
         "  --listen           a numeric address besides this machine's own; needs --token\n"
         "  --token            a file of 16 to 1024 bytes whose text every client must bring\n"
         "  --udp              send positions as datagrams to clients that ask for them\n"
         "  --force-limit      0.01..40 N; no client can raise it (8, or the device's peak)\n"
         "  --stiffness-limit  0..20000 N/m, of a client's spring (0.6 of the device's, or 500)\n"
         "  --damping-limit    0..1000 N s/m, of a client's damper (the device's, or 5)\n"
         "  --grab-radius      0..1000 mm, between the handle and a control point it can drag "
         "(10)\n"
         "  --rate             200..4000 ticks a second (1000)\n"
         "  --trace            a CSV file with one row a tick: position, velocity, force\n"
         "  --once             end when the last client has left\n"
         "  --path             a file of rows `ms x y z [buttons]`, mm, for the hand of sim\n"
         "  --hand             free, rigid, spring or person: holds the handle of sim (spring)\n"
         "\n"
         "SIGINT and SIGTERM end it with no force. SIGUSR1 is an emergency stop, which no client "
         "can\n"
         "release; SIGUSR2 releases it, and the motors stay off until a client says start.\n";
}

ParsedOptions parse_options(int count, const char* const* words) {
  ParsedOptions parsed;
  for (int i = 1; i < count; ++i) {
    const std::string name = words[i];
    if (name == "--once") {
      parsed.options.once = true;
    } else if (name == "--udp") {
      parsed.options.udp = true;
    } else if (name == "--help" || name == "-h") {
      parsed.options.help = true;
    } else {
      bool known = false;
      for (const std::string_view one : kWithValue)
        known = known || name == one;
      if (!known)
        return {{}, "there is no option " + name + "; --help shows all"};
      if (i + 1 == count)
        return {{}, name + " lacks its value"};
      const std::string value = words[++i];
      if (!set(name, value, parsed.options))
        return {{}, programs::option_refusal(usage(), name, value)};
    }
  }
  return parsed;
}

} // namespace tactus::haptic_server
