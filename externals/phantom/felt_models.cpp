#include "externals/phantom/felt_models.hpp"

#include "core/declaration_text.hpp"
#include "externals/phantom/effect_message.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/text.hpp"

namespace tactus::phantom {

using haptic::NetworkModel;

std::string FeltModels::scene(Words words, ServoRig& rig, const Limits& limits, Host& host) {
  if (std::string refusal = scene_.handle(words, host); !refusal.empty())
    return refusal;
  rig.scene.publish(scene_.snapshot());
  if (!is(words[0], "move") && !is(words[0], "del"))
    warn_of_scene(limits, host);
  return {};
}

std::string FeltModels::effect(Words words, ServoRig& rig, const Limits& limits, Host& host) {
  if (std::string refusal = read_effect(words, effects_); !refusal.empty())
    return refusal;
  rig.effects.set(effects_);
  warn_of_effect(text_of(words[0]), limits, host);
  return {};
}

std::string FeltModels::network(Words words, ServoRig& rig, double period_s, const Limits& limits,
                                Host& host) {
  if (is(words[0], "pluck") || is(words[0], "reset"))
    return act(words, rig);
  const double before_hz = network_.stepping(period_s).rate_hz;
  if (std::string refusal = network_.handle(words, host, period_s); !refusal.empty())
    return refusal;
  rig.network.publish(network_.snapshot());
  const auto stepping = network_.stepping(period_s);
  if (!stepping.reason.empty() && stepping.rate_hz != before_hz)
    host.log("network: stepped at " + number_text(stepping.rate_hz) + " Hz: " + stepping.reason);
  const haptic::Network& network = network_.network();
  constexpr double kLate = 0.5; // the mean over a tick's steps adds half a tick of delay
  const bool touch = is(words[0], "touch"), grab = is(words[0], "grab");
  if (limits && (touch || grab)) {
    const std::string what = touch ? "network touch" : "network grab";
    warnings_.stiffness(what,
                        touch ? network.touch.stiffness_n_per_m : network.grab.stiffness_n_per_m,
                        *limits, host, kLate);
    warnings_.damping(what,
                      touch ? network.touch.damping_n_s_per_m : network.grab.damping_n_s_per_m,
                      *limits, host);
  }
  return grab ? act(words, rig) : std::string();
}

/// Actions of the hand on the network.
std::string FeltModels::act(Words words, ServoRig& rig) {
  NetworkModel::Action action;
  if (is(words[0], "pluck")) {
    constexpr Range ranges[] = {{"fx", "N", -100, 100},
                                {"fy", "N", -100, 100},
                                {"fz", "N", -100, 100},
                                {"time", "ms", 0, 10000}};
    double v[4] = {};
    if (words.size() != 6)
      return "network pluck: expected a mass, fx fy fz in N and ms";
    const NamedNetwork::Found found = network_.movable(words[1]);
    std::string refusal = found.refusal;
    if (refusal.empty())
      refusal = read_numbers(words.subspan(2), ranges, v);
    if (!refusal.empty())
      return "network pluck: " + refusal;
    action = NetworkModel::Pluck{found.key, {v[0], v[1], v[2]}, v[3] * 1e-3};
  } else if (is(words[0], "grab")) {
    if (is(words[1], "off"))
      action = NetworkModel::Release{};
    else if (is(words[1], "nearest"))
      action = NetworkModel::GrabNearest{};
    else
      action = NetworkModel::Grab{network_.movable(words[1]).key};
  }
  if (rig.network.queue_action(action))
    return {};
  return "network " + std::string(words[0].word) +
         ": 64 actions are queued and the servo does not run: expected an open device";
}

void FeltModels::publish(ServoRig& rig) const {
  rig.scene.publish(scene_.snapshot());
  rig.network.publish(network_.snapshot());
  rig.effects.set(effects_);
}

void FeltModels::warn(const Limits& limits, Host& host) {
  warn_of_scene(limits, host);
  for (const char* effect : {"spring", "viscous", "inertia", "friction", "texture"})
    warn_of_effect(effect, limits, host);
}

void FeltModels::warn_of_scene(const Limits& limits, Host& host) {
  if (!limits)
    return;
  const NamedScene::NamedStiffness stiffest = scene_.max_stiffness();
  warnings_.stiffness("scene: " + stiffest.name, stiffest.stiffness_n_per_m, *limits, host);
  const NamedScene::NamedDamping damped = scene_.max_damping();
  warnings_.damping("scene: " + damped.name, damped.damping_n_s_per_m, *limits, host);
}

void FeltModels::warn_of_effect(const std::string& name, const Limits& limits, Host& host) {
  if (!limits)
    return;
  warnings_.stiffness("effect " + name, effect_stiffness(name, effects_), *limits, host);
  warnings_.damping("effect " + name, effect_damping(name, effects_), *limits, host);
}

void FeltModels::check_network(double period_s, Host& host) const {
  const auto stepping = network_.stepping(period_s);
  if (!(stepping.rate_hz > 0))
    host.error("network: stopped: at " + number_text(1 / period_s) + " ticks a second, " +
               stepping.reason);
}

void FeltModels::dump(double period_s, Host& host) const {
  scene_.dump(host);
  dump_effects(effects_, host);
  network_.dump(host, period_s);
}

void StabilityWarnings::stiffness(const std::string& what, double n_per_m,
                                  const StabilityLimits& limits, Host& host, double share) {
  const double bound = share * limits.stiffness_n_per_m;
  if (!(n_per_m > bound) || n_per_m <= warned_n_per_m_)
    return;
  warned_n_per_m_ = n_per_m;
  host.log(what + " has " + number_text(n_per_m) + " N/m, above the " + number_text(bound) +
           " N/m up to which this device is stable: it may vibrate. Raise damp or rate, or lower "
           "the stiffness");
  reports_.send(kStatus, {"status", "stiff", n_per_m, bound}, host);
}

void StabilityWarnings::damping(const std::string& what, double n_s_per_m,
                                const StabilityLimits& limits, Host& host) {
  const double bound = limits.damping_n_s_per_m;
  if (!(n_s_per_m > bound) || n_s_per_m <= warned_n_s_per_m_)
    return;
  warned_n_s_per_m_ = n_s_per_m;
  host.log(what + " has " + number_text(n_s_per_m) + " N s/m, above the " + number_text(bound) +
           " N s/m up to which this device is stable");
  reports_.send(kStatus, {"status", "damped", n_s_per_m, bound}, host);
}

} // namespace tactus::phantom
