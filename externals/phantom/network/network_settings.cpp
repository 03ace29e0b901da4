#include "externals/phantom/network/named_network.hpp"
#include "externals/phantom/words.hpp"

/// NamedNetwork's messages for motion, touch, grab and pickups.
namespace tactus::phantom {
std::string NamedNetwork::set_motion(Words words) {
  constexpr Range kGravity[] = {
      {"gx", "m/s^2", -100, 100}, {"gy", "m/s^2", -100, 100}, {"gz", "m/s^2", -100, 100}};
  constexpr Range kDrag[] = {{"drag", "1/s", 0, 10000}};
  constexpr Range kRate[] = {{"rate", "Hz", 1000, 200000}};
  if (is(words[0], "drag"))
    return read_some(words.subspan(1), kDrag, 1, &network_.drag_per_s);
  if (is(words[0], "rate"))
    return read_some(words.subspan(1), kRate, 1, &network_.rate_hz);
  double g[3] = {};
  std::string refusal = read_some(words.subspan(1), kGravity, 3, g);
  network_.gravity = {g[0], g[1], g[2]};
  return refusal;
}

std::string NamedNetwork::set_touch(Words words) {
  constexpr Range ranges[] = {{"radius", "mm", 0, 200}, {"k", "N/m", 0, 1e5}, kNetworkDamping};
  auto& touch = network_.touch;
  double v[3] = {0, touch.stiffness_n_per_m, touch.damping_n_s_per_m};
  std::string refusal = read_some(words, ranges, 1, v);
  touch = {v[0] * 1e-3, v[1], v[2]};
  return refusal;
}

/// Checks the mass and sets the spring; NetworkModel::Action performs the grab.
std::string NamedNetwork::set_grab(Words words) {
  constexpr Range ranges[] = {{"k", "N/m", 1, 1e5}, kNetworkDamping};
  if (words.empty())
    return "expected a mass, nearest or off";
  if (is(words[0], "off"))
    return words.size() == 1 ? "" : "off takes no numbers";
  if (!is(words[0], "nearest"))
    if (std::string refusal = movable(words[0]).refusal; !refusal.empty())
      return refusal;
  auto& grab = network_.grab;
  double v[2] = {grab.stiffness_n_per_m, grab.damping_n_s_per_m};
  std::string refusal = read_some(words.subspan(1), ranges, 0, v);
  grab = {v[0], v[1]};
  return refusal;
}

std::string NamedNetwork::set_pickup(Words words) {
  using Quantity = haptic::NetworkPickup::Quantity;
  constexpr Range kOutlet[] = {{"outlet", "", 1, static_cast<double>(haptic::Network::kPickups)}};
  const bool off = !words.empty() && is(words[0], "off");
  const std::size_t fixed = off ? 1 : 2;
  if (words.size() < fixed || words.size() > fixed + 2)
    return "expected a mass and x, y or z, then the outlet and velocity, displacement or force; "
           "or off";
  haptic::NetworkPickup pickup;
  if (!off) {
    pickup.mass = find(text_of(words[0]));
    if (pickup.mass == kNone)
      return text_of(words[0]) + ": no such mass";
    pickup.axis = is(words[1], "x") ? 0 : is(words[1], "y") ? 1 : is(words[1], "z") ? 2 : -1;
    if (pickup.axis < 0)
      return expected("axis", words[1], "x, y or z");
  }
  double outlet = 1;
  words = words.subspan(fixed);
  if (!words.empty() && !words[0].is_word) {
    if (std::string refusal = read_numbers(words, kOutlet, &outlet); !refusal.empty())
      return refusal;
    words = words.subspan(1);
  }
  if (!words.empty()) {
    if (is(words[0], "displacement"))
      pickup.quantity = Quantity::kDisplacement;
    else if (is(words[0], "force"))
      pickup.quantity = Quantity::kForce;
    else if (!is(words[0], "velocity"))
      return expected("quantity", words[0], "velocity, displacement or force");
  }
  network_.pickups[static_cast<std::size_t>(outlet) - 1] = pickup;
  return {};
}

} // namespace tactus::phantom
