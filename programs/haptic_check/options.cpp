#include "programs/haptic_check/options.hpp"

namespace tactus::haptic_check {
namespace {

bool set_number(const std::string& name, const char* value, Options& options) {
  const auto real = [value](double min, double max, auto& target) {
    const auto parsed = programs::number_of(value, min, max);
    if (parsed)
      target = *parsed;
    return parsed.has_value();
  };
  if (name == "--seconds")
    return real(0.5, 300, options.seconds);
  if (name == "--rate")
    return real(200, 4000, options.rate_hz);
  return name == "--force" && real(0.1, 20, options.force_n);
}

} // namespace

const char* usage() noexcept {
  return "haptic_check [--list] [--device DRIVER[:WHICH]] [--set \"NAME VALUE\"]... [--yes]\n"
         "             [--seconds S] [--force N] [--rate HZ] [--report FILE]\n"
         "\n"
         "  --list      show what is plugged in and what is missing, and end\n"
         "  --device    sim, falcon, hid, openhaptics, dhd, haply, evdev; WHICH is an index, a\n"
         "              serial number or a path. Without it: the first device that is ready\n"
         "  --set       one setting of the device, as [phantom] takes it: --set \"peak 3\"\n"
         "  --yes       ask nothing; for tests. Somebody must hold the handle all the same\n"
         "  --seconds   how long each of the four stations lasts, 0.5..300 (8)\n"
         "  --force     the most force in newtons, 0.1..20 (a quarter of the device's, 1..3)\n"
         "  --rate      ticks a second, 200..4000 (1000)\n"
         "  --report    where the report goes (haptic_check.txt)\n";
}

ParsedOptions parse_options(int count, const char* const* words) {
  ParsedOptions parsed;
  Options& options = parsed.options;
  for (int i = 1; i < count; ++i) {
    const std::string name = words[i];
    const char* value = i + 1 < count ? words[i + 1] : nullptr;
    if (name == "--list")
      options.list = true;
    else if (name == "--yes")
      options.yes = true;
    else if (name == "--help" || name == "-h")
      options.help = true;
    else if (!value)
      return {{}, name + " is no option, or lacks its value"};
    else {
      ++i;
      if (const auto taken = programs::set_device_option(name, value, options.device)) {
        if (!*taken)
          return {{}, name + " " + value + " is not understood"};
      } else if (name == "--report") {
        options.report = value;
      } else if (!set_number(name, value, options)) {
        return {{}, name + " " + value + " is not understood"};
      }
    }
  }
  return parsed;
}

} // namespace tactus::haptic_check
