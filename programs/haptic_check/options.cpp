#include "programs/haptic_check/options.hpp"

#include <charconv>
#include <sstream>

namespace tactus::haptic_check {
namespace {

bool number(const char* word, double least, double most, double& value) {
  const std::string text = word;
  double parsed = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, parsed);
  if (failed != std::errc() || stopped != end || !(parsed >= least && parsed <= most))
    return false;
  value = parsed;
  return true;
}

std::vector<std::string> words_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;)
    words.push_back(word);
  return words;
}

bool set_number(const std::string& name, const char* value, Options& options) {
  if (name == "--seconds")
    return number(value, 0.5, 300, options.seconds);
  if (name == "--rate")
    return number(value, 200, 4000, options.rate_hz);
  double force_n = 0;
  if (name != "--force" || !number(value, 0.1, 20, force_n))
    return false;
  options.force_n = force_n;
  return true;
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
      if (name == "--device") {
        const std::string wanted = value;
        const auto colon = wanted.find(':');
        options.driver = wanted.substr(0, colon);
        options.which = colon == std::string::npos ? "" : wanted.substr(colon + 1);
      } else if (name == "--set") {
        options.settings.push_back(words_of(value));
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
