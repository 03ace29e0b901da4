#include "externals/phantom/scene/felt_models.hpp"

#include "core/declaration_text.hpp"
#include "externals/phantom/scene/effect_message.hpp"

#include <limits>

namespace tactus::phantom {

using haptic::NetworkModel;

namespace {

constexpr double kNoLimit = std::numeric_limits<double>::infinity();
constexpr double kLate = 0.5; // the mean over a network's steps in a tick adds half a tick of delay

} // namespace

/// The stiffness and damping that the device renders stably. The stiffness is the device's own
/// limit or else Colgate's bound of a sampled spring, K < 2 (B + b)/T. There are no limits for a
/// real device without motors, and none for a real device that is not open, since its capabilities
/// are unknown.
FeltModels::Limits FeltModels::limits() const noexcept {
  const haptic::Caps caps = link_.device().caps();
  if (link_.is_real() && !(link_.is_open() && caps.axes_out > 0))
    return {kNoLimit, kNoLimit};
  const double own = caps.stiffness_limit_n_per_m;
  const double viscous = link_.is_real() ? 0.0 : link_.simulated.settings().viscous_n_s_per_m;
  const double damping = setup_.given.damp_n_s_per_m, period_s = link_.period_s();
  return {own > 0 ? own : 2 * (damping + viscous) / period_s,
          haptic::EffectModel::max_passive_damping(caps.damping_limit_n_s_per_m, period_s)};
}

void FeltModels::scene(Words words, Host& host) {
  if (const std::string refusal = scene_.handle(words, host); !refusal.empty())
    return host.error(refusal);
  session_.rig().scene.publish(scene_.snapshot());
  if (!is(words[0], "move") && !is(words[0], "del"))
    warn_of_scene(host);
}

void FeltModels::effect(Words words, Host& host) {
  if (const std::string refusal = read_effect(words, effects_); !refusal.empty())
    return host.error(refusal);
  session_.rig().effects.set(effects_);
  warn_of_effects(text_of(words[0]), host);
}

void FeltModels::network(Words words, Host& host) {
  std::string refusal;
  if (!is(words[0], "pluck") && !is(words[0], "reset")) {
    const double period_s = link_.period_s(), before_hz = network_.stepping(period_s).rate_hz;
    refusal = network_.handle(words, host, period_s);
    if (!refusal.empty())
      return host.error(refusal);
    session_.rig().network.publish(network_.snapshot());
    const auto stepping = network_.stepping(period_s);
    if (!stepping.reason.empty() && stepping.rate_hz != before_hz)
      host.log("network: stepped at " + number_text(stepping.rate_hz) + " Hz: " + stepping.reason);
    const haptic::Network& network = network_.network();
    if (is(words[0], "touch"))
      return warn("network touch", network.touch.stiffness_n_per_m, network.touch.damping_n_s_per_m,
                  host, kLate);
    if (!is(words[0], "grab"))
      return;
    warn("network grab", network.grab.stiffness_n_per_m, network.grab.damping_n_s_per_m, host,
         kLate);
  }
  refusal = act(words);
  if (!refusal.empty())
    host.error(refusal);
}

/// Carries out actions of the hand on the network.
std::string FeltModels::act(Words words) {
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
  if (session_.rig().network.queue_action(action))
    return {};
  return "network " + std::string(words[0].word) +
         ": 64 actions are queued and the servo does not run: expected an open device";
}

void FeltModels::publish() const {
  ServoRig& rig = session_.rig();
  rig.scene.publish(scene_.snapshot());
  rig.network.publish(network_.snapshot());
  rig.effects.set(effects_);
}

void FeltModels::warn(Host& host) {
  warn_of_scene(host);
  warn_of_effects({}, host);
}

void FeltModels::warn_of_scene(Host& host) {
  const auto stiffest = scene_.max_of(&haptic::Material::stiffness_n_per_m);
  warn("scene: " + stiffest.name, stiffest.value, 0, host);
  const auto damped = scene_.max_of(&haptic::Material::damping_n_s_per_m);
  warn("scene: " + damped.name, 0, damped.value, host);
}

/// Warns of the effect of that name; of all effects if the name is empty.
void FeltModels::warn_of_effects(std::string_view name, Host& host) {
  visit_demands(effects_, [&](std::string_view effect, EffectDemand demand) {
    if (name.empty() || effect == name)
      warn("effect " + std::string(effect), demand.stiffness_n_per_m, demand.damping_n_s_per_m,
           host);
  });
}

/// Warns of more stiffness or damping than the device renders stably, once for each new maximum.
/// `share` multiplies the limit of the stiffness, for a model whose force is delayed.
void FeltModels::warn(const std::string& what, double n_per_m, double n_s_per_m, Host& host,
                      double share) {
  const Limits device = limits();
  const double stiff = share * device.stiffness_n_per_m, damped = device.damping_n_s_per_m;
  if (n_per_m > stiff && n_per_m > warned_n_per_m_) {
    warned_n_per_m_ = n_per_m;
    host.log(what + " has " + number_text(n_per_m) + " N/m, above the " + number_text(stiff) +
             " N/m up to which this device is stable: it may vibrate. Raise damp or rate, or lower "
             "the stiffness");
    reports_.send(kStatus, {"status", "stiff", n_per_m, stiff}, host);
  }
  if (n_s_per_m > damped && n_s_per_m > warned_n_s_per_m_) {
    warned_n_s_per_m_ = n_s_per_m;
    host.log(what + " has " + number_text(n_s_per_m) + " N s/m, above the " + number_text(damped) +
             " N s/m up to which this device is stable");
    reports_.send(kStatus, {"status", "damped", n_s_per_m, damped}, host);
  }
}

void FeltModels::check_network(Host& host) const {
  const double period_s = link_.period_s();
  const auto stepping = network_.stepping(period_s);
  if (!(stepping.rate_hz > 0))
    host.error("network: stopped: at " + number_text(1 / period_s) + " ticks a second, " +
               stepping.reason);
}

void FeltModels::dump(Host& host) const {
  scene_.dump(host);
  dump_effects(effects_, host);
  network_.dump(host, link_.period_s());
}

} // namespace tactus::phantom
