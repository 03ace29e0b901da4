#include "programs/haptic_check/options.hpp"

namespace tactus::haptic_check {

const char* usage() noexcept {
  return "haptic_check [--list] [--device DRIVER[:WHICH]] [--set \"NAME VALUE\"]... [--yes]\n"
         "             [--seconds S] [--force N] [--rate HZ] [--report FILE]\n"
         "\n"
         "  --list      list devices and missing libraries, then exit\n"
         "  --device    sim, falcon, hid, openhaptics, dhd, haply or evdev; WHICH is an index, a\n"
         "              serial number or a path (the first device that is ready)\n"
         "  --set       a setting of the device, as for [phantom]: --set \"peak 3\"\n"
         "  --yes       ask no questions, for tests; somebody must still hold the handle\n"
         "  --seconds   0.5..300 s for each of the four stations (8)\n"
         "  --force     0.1..20 N, the largest force (a quarter of the device's, within 1..3)\n"
         "  --rate      200..4000 ticks a second (1000)\n"
         "  --report    name of the report's file (haptic_check.txt)\n";
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
