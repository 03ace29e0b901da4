#include "core/declaration_text.hpp"
#include "core/refusal.hpp"
#include "externals/phantom/effect_message.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/tags.hpp"

#include <cmath>

/// [phantom]'s messages for settings. A refused message changes nothing and reports one sentence.
namespace tactus {

using namespace phantom;

void Phantom::on_list(Words words, Host& host) {
  for (const Atom& atom : words)
    if (atom.is_word)
      return host.error(expected("list", atom, "three numbers, fx fy fz"));
  for (std::size_t inlet = 3; inlet-- > 0;)
    scalar(inlet, words[inlet].number, host);
}

void Phantom::on_clock(Words words, Host& host) {
  if (is(words[0], "logical") && driver_ && link_ != Link::kClosed)
    return host.error("clock logical: a real device cannot be stepped by the patch's time");
  if (is(words[0], "auto"))
    clock_ = Clock::kAuto;
  else if (is(words[0], "logical"))
    clock_ = Clock::kLogical;
  else if (is(words[0], "wall"))
    clock_ = Clock::kWall;
  else
    return host.error(expected("clock", words[0], "auto, logical or wall"));
  if (driver_)
    return; // a real device always runs on the wall clock
  wall_ = clock_ == Clock::kWall;
  restart(host);
}

void Phantom::on_workspace(Words words, Host& host) {
  haptic::Workspace& workspace = settings_.chain.workspace;
  if (words.size() == 1 && is(words[0], "device")) {
    const haptic::Caps caps = device().caps();
    workspace = {caps.workspace_min, caps.workspace_max};
    learning_ = own_workspace_ = false;
  } else if (words.size() == 2 && is(words[0], "learn") && !words[1].is_word) {
    const bool begin = words[1].number != 0;
    if (begin && has_report_ && !learning_) {
      const Vec3 here = exchange().reports.latest().state.position;
      workspace = {here, here};
    }
    if (learning_ && !begin)
      send_workspace(host);
    learning_ = begin;
    own_workspace_ = true;
  } else if (words.size() == 6) {
    constexpr Range ranges[] = {millimetres("xmin"), millimetres("ymin"), millimetres("zmin"),
                                millimetres("xmax"), millimetres("ymax"), millimetres("zmax")};
    double mm[6];
    const std::string refusal = read_numbers(words, ranges, mm);
    if (!refusal.empty())
      return host.error("workspace: " + refusal);
    const haptic::Workspace changed{metres(mm), metres(mm + 3)};
    if (!changed.valid())
      return host.error(tactus::refusal("workspace", words,
                                        "xmin ymin zmin xmax ymax zmax in mm, no minimum above "
                                        "its maximum"));
    workspace = changed;
    learning_ = false;
    own_workspace_ = true;
  } else {
    return host.error(
        refusal("workspace", words, "device, learn 0|1 or xmin ymin zmin xmax ymax zmax in mm"));
  }
  apply_settings();
}

void Phantom::on_map(Words words, Host& host) {
  std::array<double, 3> signs{1, 1, 1};
  for (std::size_t i = 1; i < words.size() && i < 4; ++i)
    signs[i - 1] = words[i].number;
  const auto map = words[0].is_word && (words.size() == 1 || words.size() == 4)
                       ? haptic::AxisMap::parse(words[0].word, signs)
                       : std::nullopt;
  if (!map)
    return host.error(
        refusal("map", words, "the letters x, y and z in any order, then three signs 1 or -1"));
  settings_.map = *map;
  apply_settings();
}

void Phantom::on_interp(Words words, Host& host) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  auto& chain = settings_.chain;
  if (is(words[0], "auto")) {
    chain.interpolation = Interpolation::kAuto;
  } else if (is(words[0], "off")) {
    chain.interpolation = Interpolation::kOff;
  } else if (!words[0].is_word && words[0].number >= 0.25 && words[0].number <= 1000) {
    chain.interpolation = Interpolation::kFixed;
    chain.interpolation_s = words[0].number * 1e-3;
  } else {
    return host.error(expected("interp", words[0], "auto, off or 0.25..1000 ms"));
  }
  apply_settings();
}

void Phantom::on_watchdog(Words words, Host& host) {
  constexpr Range ranges[] = {{"hold", "ms", 1, 10000}, {"ramp", "ms", 1, 10000}};
  double ms[2];
  const std::string refusal = read_numbers(words, ranges, ms);
  if (!refusal.empty())
    return host.error("watchdog: " + refusal);
  settings_.chain.hold_s = ms[0] * 1e-3;
  settings_.chain.ramp_s = ms[1] * 1e-3;
  apply_settings();
}

void Phantom::on_scene(Words words, Host& host) {
  if (const std::string refusal = scene_.handle(words, host); !refusal.empty())
    return host.error(refusal);
  rig_->scene.publish(scene_.snapshot());
  if (!is(words[0], "move") && !is(words[0], "del"))
    warn_of_scene(host);
}

void Phantom::warn_of_scene(Host& host) {
  const NamedScene::NamedStiffness max_stiffness = scene_.max_stiffness();
  warn_of_stiffness("scene: " + max_stiffness.name, max_stiffness.stiffness_n_per_m, host);
  const NamedScene::NamedDamping damped = scene_.max_damping();
  warn_of_damping("scene: " + damped.name, damped.damping_n_s_per_m, host);
}

/// Whether warnings of unstable stiffness apply. Not for a device without motors, and for a real
/// device only once it is open, when its capabilities are known.
bool Phantom::renders_force() const noexcept {
  return !driver_ || (open() && device_->caps().axes_out > 0);
}

/// Warns where a stiffness exceeds the limit of stable rendering: the one that the device states,
/// or else Colgate's bound of a sampled spring, K < 2 (B + b)/T. share: factor on the limit for a
/// model whose force comes late.
void Phantom::warn_of_stiffness(const std::string& what, double stiffness_n_per_m, Host& host,
                                double share) {
  if (!renders_force())
    return;
  const double own = device().caps().stiffness_limit_n_per_m;
  const double viscous = driver_ ? 0.0 : given_simulation_.viscous_n_s_per_m;
  const double bound = share * (own > 0 ? own : 2 * (given_.damp_n_s_per_m + viscous) / period_s());
  if (!(stiffness_n_per_m > bound) || stiffness_n_per_m <= warned_n_per_m_)
    return;
  warned_n_per_m_ = stiffness_n_per_m;
  host.log(what + " has " + number_text(stiffness_n_per_m) + " N/m, above the " +
           number_text(bound) +
           " N/m up to which this device is stable: it may vibrate. Raise damp or rate, "
           "or lower the stiffness");
  if (reported_[kStatus])
    host.info({"status", "stiff", stiffness_n_per_m, bound});
}

void Phantom::warn_of_damping(const std::string& what, double damping_n_s_per_m, Host& host) {
  if (!renders_force())
    return;
  const double bound =
      haptic::EffectModel::max_passive_damping(device().caps().damping_limit_n_s_per_m, period_s());
  if (!(damping_n_s_per_m > bound) || damping_n_s_per_m <= warned_n_s_per_m_)
    return;
  warned_n_s_per_m_ = damping_n_s_per_m;
  host.log(what + " has " + number_text(damping_n_s_per_m) + " N s/m, above the " +
           number_text(bound) + " N s/m up to which this device is stable");
  if (reported_[kStatus])
    host.info({"status", "damped", damping_n_s_per_m, bound});
}

void Phantom::dump(Host& host) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  const auto& chain = settings_.chain;
  host.info({"backend", driver_name()});
  host.info({"name", std::string_view(name_)});
  host.info({"clock", wall_ ? "wall" : "logical"});
  host.info({"estop", exchange().motors.request().stopped ? 1.0 : 0.0});
  send_workspace(host);
  std::string axes;
  for (const int source : settings_.map.source)
    axes += static_cast<char>('x' + source);
  const auto& sign = settings_.map.sign;
  host.info({"map", std::string_view(axes), sign[0], sign[1], sign[2]});
  if (chain.interpolation == Interpolation::kFixed)
    host.info({"interp", chain.interpolation_s * 1e3});
  else
    host.info({"interp", chain.interpolation == Interpolation::kAuto ? "auto" : "off"});
  host.info({"watchdog", chain.hold_s * 1e3, chain.ramp_s * 1e3});
  scene_.dump(host);
  dump_effects(effect_settings_, host);
  network_.dump(host, period_s());
  if (!driver_)
    dump_hand(host);
}

} // namespace tactus
