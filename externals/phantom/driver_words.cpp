#include "externals/phantom/driver_words.hpp"

#include "devices/driver.hpp"
#include "externals/phantom/text.hpp"

#include <vector>

namespace tactus::phantom {

std::string driver_names(bool with_simulation) {
  std::vector<std::string_view> all;
  if (with_simulation)
    all.emplace_back("sim");
  for (const devices::Driver* driver : devices::drivers())
    all.emplace_back(driver->name);
  std::string names;
  for (std::size_t i = 0; i < all.size(); ++i)
    names += (i == 0 ? "" : i + 1 == all.size() ? " or " : ", ") + std::string(all[i]);
  return names;
}

std::string configure(haptic::Backend& device, std::span<const Atom> words, bool which) {
  std::vector<std::string> texts;
  if (which)
    texts.emplace_back("device");
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  return device.configure(texts);
}

std::string configure_new(haptic::Backend& device, std::span<const Atom> words) {
  if (words.size() > 1 && configure(device, words, false).empty())
    return {};
  return configure(device, words, true);
}

void send_device(std::string_view driver, std::size_t index, const haptic::Identity& identity,
                 std::string_view state, Host& host) {
  const auto word = [](const std::string& text) {
    return text.empty() ? std::string_view("-") : std::string_view(text);
  };
  host.info({"device", driver, static_cast<double>(index), word(identity.vendor),
             word(identity.model), word(identity.serial), state.empty() ? "-" : state});
}

} // namespace tactus::phantom
