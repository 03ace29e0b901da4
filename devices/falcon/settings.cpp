#include "core/text.hpp"
#include "devices/falcon/falcon.hpp"

#include <array>
#include <string_view>

namespace tactus::devices::falcon {
namespace {

constexpr double kMinGain = 1e3, kMaxGain = 1e5;

struct Light {
  std::string_view name;
  int flags;
};
constexpr std::array<Light, 5> kLights{{{"auto", -1},
                                        {"off", 0},
                                        {"red", Command::kRed},
                                        {"green", Command::kGreen},
                                        {"blue", Command::kBlue}}};

// The flags of all colours together; nullopt if a word is not accepted.
std::optional<int> lights_of(std::span<const std::string> words) {
  std::optional<int> sum;
  for (const std::string& word : words) {
    const auto* light = kLights.begin();
    while (light != kLights.end() && light->name != word)
      ++light;
    if (light == kLights.end() || (light->flags <= 0 && words.size() > 1))
      return std::nullopt;
    sum = sum.value_or(0) | light->flags;
  }
  return sum;
}

} // namespace

std::string Falcon::configure(std::span<const std::string> words) {
  const std::string name = words.empty() ? std::string() : words[0];
  const auto values = words.empty() ? words : words.subspan(1);
  if (name == "device" && values.size() == 1) {
    const std::scoped_lock lock(mutex_);
    settings_.device = values[0];
    return {};
  }
  if (name == "firmware" && values.size() == 1) {
    const std::scoped_lock lock(mutex_);
    settings_.firmware = values[0];
    return {};
  }
  if (name == "reload" && values.empty()) {
    const std::scoped_lock lock(mutex_);
    settings_.reload = true;
    return {};
  }
  if (name == "probe" && values.size() == 1 && (values[0] == "0" || values[0] == "1")) {
    const std::scoped_lock lock(mutex_);
    settings_.probe = values[0] == "1";
    return {};
  }
  if ((name == "home" || name == "calibrate") && values.empty()) {
    home_requested_ = true;
    return {};
  }
  if (name == "led") {
    const auto lights = lights_of(values);
    if (!lights)
      return "falcon: led: expected auto, off, or any of red, green and blue";
    lights_ = *lights;
    return {};
  }
  if (name == "gain" && values.size() == 1) {
    const auto gain = to_number(values[0], kMinGain, kMaxGain);
    if (!gain)
      return "falcon: gain " + values[0] +
             ": expected 1000..100000 motor counts per N m (10000 unless you have measured another "
             "value)";
    counts_per_n_m_ = *gain;
    return {};
  }
  return "falcon: setting " + (name.empty() ? std::string("nothing") : name) +
         ": expected device WHICH, firmware FILE, reload, probe 0|1, home, led COLOUR or gain "
         "COUNTS";
}

} // namespace tactus::devices::falcon
