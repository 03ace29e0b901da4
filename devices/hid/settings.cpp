#include "core/text.hpp"
#include "devices/hid/hid.hpp"

namespace tactus::devices::hid {

std::string Hid::configure(std::span<const std::string> words) {
  if (words.size() == 2) {
    const std::string& name = words[0];
    if (name == "device" || name == "table") {
      const std::scoped_lock lock(mutex_);
      (name == "device" ? settings_.device : settings_.table) = words[1];
      return {};
    }
    if (name == "mapping" || name == "transport")
      return set_name(name, words[1]);
    if (name == "speed" || name == "deadzone" || name == "led")
      return set_number(name, words[1]);
  }
  const std::string name = words.empty() ? "nothing" : words[0];
  return "hid: setting " + name +
         ": expected device WHICH, mapping position|rate, speed MM_PER_S, "
         "deadzone PERCENT, led 0|1, table FILE or transport any|hidraw|libusb";
}

std::string Hid::set_name(const std::string& name, const std::string& value) {
  if (name == "mapping") {
    if (value != "position" && value != "rate")
      return "hid: mapping " + value + ": expected position or rate";
    rate_ = value == "rate";
    return {};
  }
  const std::scoped_lock lock(mutex_);
  if (value == "any")
    settings_.transport = Transport::kAny;
  else if (value == "hidraw")
    settings_.transport = Transport::kHidraw;
  else if (value == "libusb")
    settings_.transport = Transport::kLibusb;
  else
    return "hid: transport " + value + ": expected any, hidraw or libusb";
  return {};
}

std::string Hid::set_number(const std::string& name, const std::string& text) {
  const double most = name == "speed" ? 1000 : name == "deadzone" ? 90 : 1;
  const auto number = to_number(text, 0., most);
  if (!number || (name == "led" && *number != 0 && *number != 1))
    return "hid: " + name + " " + text + ": expected " +
           (name == "speed"      ? "0..1000 mm/s"
            : name == "deadzone" ? "0..90 % of full deflection"
                                 : "0 or 1");
  if (name == "speed")
    speed_m_per_s_ = *number * 1e-3;
  else if (name == "deadzone")
    dead_zone_ = *number * 1e-2;
  else
    light_ = *number == 1;
  return {};
}

} // namespace tactus::devices::hid
