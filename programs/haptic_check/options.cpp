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
         "  --seconds   0.5..300, of each of the four stations (8)\n"
         "  --force     0.1..20 N at most (a quarter of the device's, 1..3)\n"
         "  --rate      200..4000 ticks a second (1000)\n"
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
    else if (programs::option_text(usage(), name).empty())
      return {{}, "there is no option " + name + "; --help shows all"};
    else if (!value)
      return {{}, name + " lacks its value"};
    else {
      ++i;
      if (const auto taken = programs::set_device_option(name, value, options.device)) {
        if (!*taken)
          return {{}, programs::option_refusal(usage(), name, value)};
      } else if (name == "--report") {
        options.report = value;
      } else if (!set_number(name, value, options)) {
        return {{}, programs::option_refusal(usage(), name, value)};
      }
    }
  }
  return parsed;
}

} // namespace tactus::haptic_check
