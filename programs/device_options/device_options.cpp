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

} // namespace tactus::programs
