#include "externals/phantom/device/drivers.hpp"

#ifdef TACTUS_NET
#include "net/remote_device.hpp"
#endif

#include <vector>

namespace tactus::phantom {
namespace {

#ifdef TACTUS_NET
// This driver lists no devices, because the user gives HOST PORT.
const devices::Driver kNetDriver{
    "net", "a device on another computer, through haptic_server", [] { return std::string(); },
    [] { return std::vector<devices::Found>(); },
    []() -> std::unique_ptr<haptic::Backend> { return std::make_unique<net::RemoteDevice>(); }};
#endif

/// Handles the words after a driver's name. They are a setting, as after `driver`, or choose a
/// device.
std::string configure_new(haptic::Backend& device, Words words) {
  if (words.size() > 1 && configure(device, words, false).empty())
    return {};
  return configure(device, words, true);
}

} // namespace

void add_net_driver() noexcept {
#ifdef TACTUS_NET
  devices::add_driver(kNetDriver);
#endif
}

std::string driver_names(bool with_simulation) {
  std::vector<std::string_view> all;
  if (with_simulation)
    all.emplace_back("sim");
  for (const devices::Driver* driver : devices::drivers())
    all.emplace_back(driver->name);
  return one_of(all);
}

std::string configure(haptic::Backend& device, Words words, bool which) {
  std::vector<std::string> texts;
  if (which)
    texts.emplace_back("device");
  for (const Atom& word : words)
    texts.push_back(text_of(word));
  return device.configure(texts);
}

DriverChoice choose_driver(Words words) {
  DriverChoice choice;
  if (is(words[0], "sim")) {
    if (words.size() > 1)
      choice.refusal = "backend sim: expected no arguments";
    return choice;
  }
  choice.driver = words[0].is_word ? devices::find_driver(words[0].word) : nullptr;
  if (!choice.driver) {
    choice.refusal = expected("backend", words[0], driver_names(true));
    return choice;
  }
  choice.device = choice.driver->make();
  if (!choice.device)
    choice.refusal =
        "backend " + std::string(choice.driver->name) + ": " + choice.driver->problem();
  else if (words.size() > 1)
    if (const std::string refusal = configure_new(*choice.device, words.subspan(1));
        !refusal.empty())
      choice.refusal = "backend " + refusal;
  return choice;
}

void send_device(std::string_view driver, int index, const haptic::Identity& identity,
                 std::string_view state, Host& host) {
  const auto word = [](const std::string& text) {
    return text.empty() ? std::string_view("-") : std::string_view(text);
  };
  host.info({"device", driver, static_cast<double>(index), word(identity.vendor),
             word(identity.model), word(identity.serial), state.empty() ? "-" : state});
}

} // namespace tactus::phantom
