#include "programs/device_options/device_options.hpp"

#include <charconv>
#include <sstream>

namespace tactus::programs {
namespace {

std::vector<std::string> split_words(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;)
    words.push_back(word);
  return words;
}

} // namespace

std::optional<bool> set_device_option(std::string_view name, const std::string& value,
                                      DeviceOptions& options) {
  if (name == "--set") {
    options.settings.push_back(split_words(value));
    return true;
  }
  if (name != "--device")
    return {};
  const auto colon = value.find(':');
  options.driver = value.substr(0, colon);
  options.which = colon == std::string::npos ? "" : value.substr(colon + 1);
  return !options.driver.empty();
}

std::string configure(haptic::Backend& device, const DeviceOptions& options) {
  auto settings = options.settings;
  if (!options.which.empty())
    settings.push_back({"device", options.which});
  for (const auto& words : settings)
    if (std::string refusal = device.configure(words); !refusal.empty())
      return refusal;
  return {};
}

std::optional<double> number_of(std::string_view text, double min, double max) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [stopped, failed] = std::from_chars(text.data(), end, value);
  if (failed != std::errc() || stopped != end || !(value >= min && value <= max))
    return {};
  return value;
}

std::string option_text(std::string_view usage, std::string_view name) {
  std::istringstream lines{std::string(usage)};
  std::string text;
  bool found = false;
  for (std::string line; std::getline(lines, line);) {
    const auto words = split_words(line);
    const bool begins = line.starts_with("  -"), continues = line.starts_with("   ");
    if (begins || !continues)
      found = begins && words[0] == name;
    if (found)
      for (std::size_t i = begins ? 1 : 0; i < words.size(); ++i)
        text += (text.empty() ? "" : " ") + words[i];
  }
  return text;
}

std::string option_refusal(std::string_view usage, const std::string& name,
                           std::string_view value) {
  const std::string expected = option_text(usage, name);
  if (expected.empty())
    return "there is no option " + name + "; --help shows all";
  return name + " " + std::string(value) + ": expected " + expected;
}

} // namespace tactus::programs
