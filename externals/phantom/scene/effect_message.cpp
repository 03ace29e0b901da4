#include "externals/phantom/scene/effect_message.hpp"

#include "core/declaration_text.hpp"

#include <numbers>
#include <optional>

/// [phantom]'s message `effect`.
namespace tactus::phantom {
namespace {

using haptic::EffectSettings;

constexpr Range force(std::string_view name) { return {name, "N", -40, 40}; }
constexpr Range part(std::string_view name) { return {name, "", -1e6, 1e6}; }

std::string read_grating(Words words, const Range& height, double* v, Vec3& direction) {
  const Range ranges[] = {
      height, {"wavelength", "mm", 0.05, 1000}, part("dx"), part("dy"), part("dz")};
  if (words.size() > 2 && words.size() != 5)
    return "expected " + std::string(height.name) + " and wavelength, then dx dy dz or nothing";
  if (std::string refusal = read_some(words, ranges, 2, v); !refusal.empty())
    return refusal;
  direction = {v[2], v[3], v[4]};
  const double length = norm(direction);
  if (!(length > 1e-6))
    return "direction 0 0 0: expected a nonzero vector";
  direction = direction * (1 / length);
  return {};
}

std::string read(Words words, EffectSettings::Constant& effect) {
  constexpr Range ranges[] = {force("fx"), force("fy"), force("fz")};
  double v[3] = {};
  std::string refusal = read_some(words, ranges, 3, v);
  effect = {{v[0], v[1], v[2]}};
  return refusal;
}

std::string read(Words words, EffectSettings::Spring& effect) {
  constexpr Range ranges[] = {{"k", "N/m", 0, 5000},
                              millimetres("x"),
                              millimetres("y"),
                              millimetres("z"),
                              {"max", "N", 0, 40}};
  double v[5] = {0, 0, 0, 0, effect.max_n};
  std::string refusal = read_some(words, ranges, 4, v);
  effect = {v[0], metres(v + 1), v[4]};
  return refusal;
}

std::string read(Words words, EffectSettings::Viscous& effect) {
  constexpr Range ranges[] = {{"b", "N s/m", 0, 50}};
  return read_some(words, ranges, 1, &effect.damping);
}

std::string read(Words words, EffectSettings::Inertia& effect) {
  constexpr Range ranges[] = {
      {"mass", "kg", 1e-3, 20}, {"k", "N/m", 1, 5000}, {"b", "N s/m", 0, 20}};
  double v[3] = {0, effect.stiffness, effect.damping};
  std::string refusal = read_some(words, ranges, 1, v);
  effect = {v[0], v[1], v[2]};
  return refusal;
}

std::string read(Words words, EffectSettings::Friction& effect) {
  constexpr Range ranges[] = {{"force", "N", 0, 40}, {"k", "N/m", 1, 5000}};
  double v[2] = {0, effect.stiffness};
  std::string refusal = read_some(words, ranges, 1, v);
  effect = {v[0], v[1]};
  return refusal;
}

std::string read(Words words, EffectSettings::Texture& effect) {
  double v[5] = {0, 1, 1, 0, 0};
  std::string refusal = read_grating(words, {"amplitude", "N", 0, 40}, v, effect.direction);
  effect.amplitude_n = v[0];
  effect.wavelength_m = v[1] * 1e-3;
  return refusal;
}

std::string read(Words words, EffectSettings::Relief& effect) {
  double v[5] = {0, 1, 1, 0, 0};
  std::string refusal = read_grating(words, {"depth", "mm", 0, 10}, v, effect.direction);
  if (refusal.empty() && v[0] > 0.25 * v[1])
    refusal = "depth " + number_text(v[0]) + " mm: expected at most a quarter of the wavelength, " +
              number_text(0.25 * v[1]) + " mm";
  effect.depth_m = v[0] * 1e-3;
  effect.wavelength_m = v[1] * 1e-3;
  return refusal;
}

/// `off`, or the numbers of one effect. Optional numbers have the default of the effect.
template <class Effect> std::string read_or_off(Words words, std::optional<Effect>& effect) {
  if (words.size() == 1 && is(words[0], "off")) {
    effect.reset();
    return {};
  }
  effect = Effect{}; // not emplace(), which clang 14 rejects for a nested aggregate
  return read(words, *effect);
}

/// Calls `visit(name, effect)` for each effect, in order.
template <class Settings, class Visit> void visit_all(Settings& settings, const Visit& visit) {
  visit("constant", settings.constant);
  visit("spring", settings.spring);
  visit("viscous", settings.viscous);
  visit("inertia", settings.inertia);
  visit("friction", settings.friction);
  visit("texture", settings.texture);
  visit("relief", settings.relief);
}

EffectDemand demand(const EffectSettings::Spring& effect) { return {effect.stiffness, 0}; }
EffectDemand demand(const EffectSettings::Viscous& effect) { return {0, effect.damping}; }
EffectDemand demand(const EffectSettings::Inertia& effect) {
  return {effect.stiffness, effect.damping};
}
EffectDemand demand(const EffectSettings::Friction& effect) { return {effect.stiffness, 0}; }
EffectDemand demand(const EffectSettings::Texture& effect) {
  return {effect.amplitude_n * 2 * std::numbers::pi / effect.wavelength_m, 0};
}
template <class Effect> EffectDemand demand(const Effect&) { return {}; }

void dump(std::string_view name, const EffectSettings::Constant& effect, Host& host) {
  const Vec3& f = effect.force_n;
  host.info({"effect", name, f.x, f.y, f.z});
}
void dump(std::string_view name, const EffectSettings::Spring& effect, Host& host) {
  const Vec3 mm = effect.centre * 1e3;
  host.info({"effect", name, effect.stiffness, mm.x, mm.y, mm.z, effect.max_n});
}
void dump(std::string_view name, const EffectSettings::Viscous& effect, Host& host) {
  host.info({"effect", name, effect.damping});
}
void dump(std::string_view name, const EffectSettings::Inertia& effect, Host& host) {
  host.info({"effect", name, effect.mass_kg, effect.stiffness, effect.damping});
}
void dump(std::string_view name, const EffectSettings::Friction& effect, Host& host) {
  host.info({"effect", name, effect.force_n, effect.stiffness});
}
void dump(std::string_view name, double height, const auto& grating, Host& host) {
  const Vec3& d = grating.direction;
  host.info({"effect", name, height, grating.wavelength_m * 1e3, d.x, d.y, d.z});
}
void dump(std::string_view name, const EffectSettings::Texture& effect, Host& host) {
  dump(name, effect.amplitude_n, effect, host);
}
void dump(std::string_view name, const EffectSettings::Relief& effect, Host& host) {
  dump(name, effect.depth_m * 1e3, effect, host);
}

} // namespace

std::string read_effect(Words words, EffectSettings& settings) {
  if (is(words[0], "off") && words.size() == 1) {
    settings = {};
    return {};
  }
  std::string refusal = expected(
      "effect", words[0], "constant, spring, viscous, inertia, friction, texture, relief or off");
  visit_all(settings, [&](std::string_view name, auto& effect) {
    if (!is(words[0], name))
      return;
    auto changed = effect;
    refusal = read_or_off(words.subspan(1), changed);
    if (refusal.empty())
      effect = changed;
    else
      refusal = "effect " + std::string(name) + ": " + refusal;
  });
  return refusal;
}

void visit_demands(const EffectSettings& settings,
                   const std::function<void(std::string_view, EffectDemand)>& visit) {
  visit_all(settings, [&](std::string_view name, const auto& effect) {
    if (effect)
      visit(name, demand(*effect));
  });
}

void dump_effects(const EffectSettings& settings, Host& host) {
  visit_all(settings, [&](std::string_view name, const auto& effect) {
    if (effect)
      dump(name, *effect, host);
  });
}

} // namespace tactus::phantom
