#include "programs/device_options/device_options.hpp"

#include "core/text.hpp"

#include <algorithm>

namespace tactus::programs {

namespace {

/// Handles --device and --set. Returns nullopt for any other option, false if the value is not
/// valid.
std::optional<bool> set_device_option(std::string_view name, const std::string& value,
                                      DeviceOptions& options) {
  if (name == "--set") {
    const auto words = split_words(value);
    options.settings.emplace_back(words.begin(), words.end());
    return true;
  }
  if (name != "--device")
    return {};
  const auto colon = value.find(':');
  options.driver = value.substr(0, colon);
  options.which = colon == std::string::npos ? "" : value.substr(colon + 1);
  return !options.driver.empty();
}

} // namespace

std::string configure(haptic::Backend& device, const DeviceOptions& options) {
  auto settings = options.settings;
  if (!options.which.empty())
    settings.push_back({"device", options.which});
  for (const auto& words : settings)
    if (std::string refusal = device.configure(words); !refusal.empty())
      return refusal;
  return {};
}

std::string option_text(std::string_view usage, std::string_view name) {
  std::string text;
  bool found = false;
  for_each_line(usage, [&](std::size_t, std::string_view line) {
    const auto words = split_words(line);
    const bool begins = line.starts_with("  -"), continues = line.starts_with("   ");
    if (begins || !continues)
      found = begins && words[0] == name;
    if (found)
      for (std::size_t i = begins ? 1 : 0; i < words.size(); ++i)
        text.append(text.empty() ? "" : " ").append(words[i]);
    return true;
  });
  return text;
}

std::string read_options(std::span<const char* const> words, std::string_view usage,
                         std::span<const Flag> flags, DeviceOptions& device, const SetOption& set) {
  for (std::size_t i = 1; i < words.size(); ++i) {
    const std::string name = words[i] == std::string_view("-h") ? "--help" : words[i];
    const auto flag =
        std::find_if(flags.begin(), flags.end(), [&](const Flag& one) { return one.name == name; });
    if (flag != flags.end()) {
      *flag->set = true;
      continue;
    }
    const std::string expected = option_text(usage, name);
    if (expected.empty())
      return "unknown option " + name + "; see --help";
    if (++i == words.size())
      return name + " needs a value";
    const std::string value = words[i];
    const auto taken = set_device_option(name, value, device);
    if (!(taken ? *taken : set(name, value)))
      return name + " " + value + ": expected " + expected;
  }
  return {};
}

} // namespace tactus::programs
