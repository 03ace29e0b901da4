#include "programs/haptic_check/options.hpp"

namespace tactus::haptic_check {

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
  Options o;
  const programs::Flag flags[] = {{"--list", &o.list}, {"--yes", &o.yes}, {"--help", &o.help}};
  std::string error = programs::read_options(
      std::span(words, static_cast<std::size_t>(count)), usage(), flags, o.device,
      [&o](std::string_view name, const std::string& value) {
        if (name == "--report")
          return o.report = value, true;
        if (name == "--seconds")
          return programs::read(value, 0.5, 300, o.seconds);
        if (name == "--rate")
          return programs::read(value, 200, 4000, o.rate_hz);
        return name == "--force" && programs::read(value, 0.1, 20, o.force_n);
      });
  return {o, error};
}

} // namespace tactus::haptic_check
