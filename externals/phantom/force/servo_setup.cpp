#include "externals/phantom/force/servo_setup.hpp"

#include "core/refusal.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace tactus::phantom {

void ServoSetup::set_workspace(Words words, Host& host) {
  if (const std::string refusal = change_workspace(words, host); !refusal.empty())
    return host.error(refusal);
  apply();
}

std::string ServoSetup::change_workspace(Words words, Host& host) {
  haptic::Workspace& workspace = settings_.chain.workspace;
  if (words.size() == 1 && is(words[0], "device")) {
    const haptic::Caps caps = link_.device().caps();
    workspace = {caps.workspace_min, caps.workspace_max};
    learning_ = own_workspace_ = false;
    return {};
  }
  if (words.size() == 2 && is(words[0], "learn") && !words[1].is_word) {
    const bool begin = words[1].number != 0;
    if (const haptic::Report* report = session_.report(); begin && report && !learning_)
      workspace = {report->state.position, report->state.position};
    if (learning_ && !begin)
      send_workspace(host);
    learning_ = begin;
    own_workspace_ = true;
    return {};
  }
  if (words.size() != 6)
    return std::string(
        refusal("workspace", words, "device, learn 0|1 or xmin ymin zmin xmax ymax zmax in mm"));
  constexpr Range ranges[] = {millimetres("xmin"), millimetres("ymin"), millimetres("zmin"),
                              millimetres("xmax"), millimetres("ymax"), millimetres("zmax")};
  double mm[6];
  if (const std::string reason = read_numbers(words, ranges, mm); !reason.empty())
    return "workspace: " + reason;
  const haptic::Workspace changed{metres(mm), metres(mm + 3)};
  if (!changed.valid())
    return std::string(refusal(
        "workspace", words, "xmin ymin zmin xmax ymax zmax in mm, no minimum above its maximum"));
  workspace = changed;
  learning_ = false;
  own_workspace_ = true;
  return {};
}

void ServoSetup::learn() noexcept {
  const haptic::Report* const report = session_.report();
  if (!learning_ || !report)
    return;
  const haptic::Workspace before = workspace();
  settings_.chain.workspace.include(report->state.position);
  if (!(before == workspace()))
    write();
}

void ServoSetup::use_workspace() noexcept {
  const haptic::Caps caps = link_.device().caps();
  if (!own_workspace_)
    settings_.chain.workspace = {caps.workspace_min, caps.workspace_max};
}

void ServoSetup::set_map(Words words, Host& host) {
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
  apply();
}

void ServoSetup::set_interpolation(const Atom& time, Host& host) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  haptic::ChainSettings& chain = settings_.chain;
  if (is(time, "auto")) {
    chain.interpolation = Interpolation::kAuto;
  } else if (is(time, "off")) {
    chain.interpolation = Interpolation::kOff;
  } else if (!time.is_word && time.number >= 0.25 && time.number <= 1000) {
    chain.interpolation = Interpolation::kFixed;
    chain.interpolation_s = time.number * 1e-3;
  } else {
    return host.error(expected("interp", time, "auto, off or 0.25..1000 ms"));
  }
  apply();
}

void ServoSetup::set_watchdog(Words words, Host& host) {
  constexpr Range ranges[] = {{"hold", "ms", 1, 10000}, {"ramp", "ms", 1, 10000}};
  double ms[2];
  if (const std::string refusal = read_numbers(words, ranges, ms); !refusal.empty())
    return host.error("watchdog: " + refusal);
  settings_.chain.hold_s = ms[0] * 1e-3;
  settings_.chain.ramp_s = ms[1] * 1e-3;
  apply();
}

void ServoSetup::apply() noexcept {
  const haptic::Caps caps = link_.device().caps();
  haptic::ChainSettings& chain = settings_.chain;
  chain.force_limit_n = given.forcemax_n;
  if (caps.peak_force_n > 0)
    chain.force_limit_n = std::min(chain.force_limit_n, caps.peak_force_n);
  chain.slew_n_per_s = given.slew_n_per_ms * 1e3;
  chain.extrapolation_s = given.extrap_ms * 1e-3;
  chain.strict = given.strict;
  chain.resume = !link_.is_real() || given.resume; // else motors 1 is needed after a freeze
  chain.passivity = given.passivity;
  chain.tank_j = given.tank_j;
  chain.allowance_w = given.allowance_w;
  chain.damping_n_s_per_m = given.damp_n_s_per_m;
  chain.wall_n_per_m = given.walls_n_per_m;
  write();
}

void ServoSetup::write() noexcept {
  session_.exchange().settings.write(settings_);
  session_.rig().signals->set_workspace(workspace());
}

void ServoSetup::send_workspace(Host& host) const {
  const Vec3 low = workspace().min * 1e3, high = workspace().max * 1e3;
  host.info({"workspace", low.x, low.y, low.z, high.x, high.y, high.z});
}

void ServoSetup::dump(Host& host) const {
  using Interpolation = haptic::ChainSettings::Interpolation;
  const haptic::ChainSettings& chain = settings_.chain;
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
}

} // namespace tactus::phantom
