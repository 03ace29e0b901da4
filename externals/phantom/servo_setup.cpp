#include "externals/phantom/servo_setup.hpp"

#include "core/refusal.hpp"
#include "externals/phantom/numbers.hpp"

#include <algorithm>
#include <array>
#include <optional>
#include <string_view>

namespace tactus::phantom {

/// `position`: where the handle is; null: not known.
std::string ServoSetup::set_workspace(Words words, const haptic::Caps& caps, const Vec3* position,
                                      Host& host) {
  haptic::Workspace& workspace = settings.chain.workspace;
  if (words.size() == 1 && is(words[0], "device")) {
    workspace = {caps.workspace_min, caps.workspace_max};
    learning_ = own_workspace_ = false;
    return {};
  }
  if (words.size() == 2 && is(words[0], "learn") && !words[1].is_word) {
    const bool begin = words[1].number != 0;
    if (begin && position && !learning_)
      workspace = {*position, *position};
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

bool ServoSetup::learn(const Vec3& position) noexcept {
  if (!learning_)
    return false;
  const haptic::Workspace before = settings.chain.workspace;
  settings.chain.workspace.include(position);
  return !(before == settings.chain.workspace);
}

void ServoSetup::use_workspace(const haptic::Caps& caps) noexcept {
  if (!own_workspace_)
    settings.chain.workspace = {caps.workspace_min, caps.workspace_max};
}

std::string ServoSetup::set_map(Words words) {
  std::array<double, 3> signs{1, 1, 1};
  for (std::size_t i = 1; i < words.size() && i < 4; ++i)
    signs[i - 1] = words[i].number;
  const auto map = words[0].is_word && (words.size() == 1 || words.size() == 4)
                       ? haptic::AxisMap::parse(words[0].word, signs)
                       : std::nullopt;
  if (!map)
    return std::string(
        refusal("map", words, "the letters x, y and z in any order, then three signs 1 or -1"));
  settings.map = *map;
  return {};
}

std::string ServoSetup::set_interpolation(Words words) {
  using Interpolation = haptic::ChainSettings::Interpolation;
  haptic::ChainSettings& chain = settings.chain;
  if (is(words[0], "auto")) {
    chain.interpolation = Interpolation::kAuto;
  } else if (is(words[0], "off")) {
    chain.interpolation = Interpolation::kOff;
  } else if (!words[0].is_word && words[0].number >= 0.25 && words[0].number <= 1000) {
    chain.interpolation = Interpolation::kFixed;
    chain.interpolation_s = words[0].number * 1e-3;
  } else {
    return expected("interp", words[0], "auto, off or 0.25..1000 ms");
  }
  return {};
}

std::string ServoSetup::set_watchdog(Words words) {
  constexpr Range ranges[] = {{"hold", "ms", 1, 10000}, {"ramp", "ms", 1, 10000}};
  double ms[2];
  if (const std::string refusal = read_numbers(words, ranges, ms); !refusal.empty())
    return "watchdog: " + refusal;
  settings.chain.hold_s = ms[0] * 1e-3;
  settings.chain.ramp_s = ms[1] * 1e-3;
  return {};
}

const haptic::ServoSettings& ServoSetup::update(const haptic::Caps& caps, bool resumes) noexcept {
  haptic::ChainSettings& chain = settings.chain;
  chain.force_limit_n = given.forcemax_n;
  if (caps.peak_force_n > 0)
    chain.force_limit_n = std::min(chain.force_limit_n, caps.peak_force_n);
  chain.slew_n_per_s = given.slew_n_per_ms * 1e3;
  chain.extrapolation_s = given.extrap_ms * 1e-3;
  chain.strict = given.strict;
  chain.resume = resumes || given.resume;
  chain.passivity = given.passivity;
  chain.tank_j = given.tank_j;
  chain.allowance_w = given.allowance_w;
  chain.damping_n_s_per_m = given.damp_n_s_per_m;
  chain.wall_n_per_m = given.walls_n_per_m;
  return settings;
}

void ServoSetup::send_workspace(Host& host) const {
  const Vec3 low = settings.chain.workspace.min * 1e3, high = settings.chain.workspace.max * 1e3;
  host.info({"workspace", low.x, low.y, low.z, high.x, high.y, high.z});
}

void ServoSetup::dump(Host& host) const {
  using Interpolation = haptic::ChainSettings::Interpolation;
  const haptic::ChainSettings& chain = settings.chain;
  send_workspace(host);
  std::string axes;
  for (const int source : settings.map.source)
    axes += static_cast<char>('x' + source);
  const auto& sign = settings.map.sign;
  host.info({"map", std::string_view(axes), sign[0], sign[1], sign[2]});
  if (chain.interpolation == Interpolation::kFixed)
    host.info({"interp", chain.interpolation_s * 1e3});
  else
    host.info({"interp", chain.interpolation == Interpolation::kAuto ? "auto" : "off"});
  host.info({"watchdog", chain.hold_s * 1e3, chain.ramp_s * 1e3});
}

} // namespace tactus::phantom
