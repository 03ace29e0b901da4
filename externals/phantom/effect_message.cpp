#include "externals/phantom/effect_message.hpp"

#include "core/declaration_text.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/text.hpp"

#include <algorithm>
#include <array>
#include <numbers>
#include <optional>

/// [phantom]'s message `effect`.
namespace tactus::phantom {
namespace {

using haptic::EffectSettings;
using Words = std::span<const Atom>;

constexpr std::array<std::string_view, 7> kNames{"constant", "spring",  "viscous", "inertia",
                                                 "friction", "texture", "relief"};
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

std::string read_named(Words words, EffectSettings& settings) {
  const Words rest = words.subspan(1);
  if (is(words[0], "constant"))
    return read_or_off(rest, settings.constant);
  if (is(words[0], "spring"))
    return read_or_off(rest, settings.spring);
  if (is(words[0], "viscous"))
    return read_or_off(rest, settings.viscous);
  if (is(words[0], "inertia"))
    return read_or_off(rest, settings.inertia);
  if (is(words[0], "friction"))
    return read_or_off(rest, settings.friction);
  if (is(words[0], "texture"))
    return read_or_off(rest, settings.texture);
  return read_or_off(rest, settings.relief);
}

} // namespace

std::string read_effect(Words words, EffectSettings& settings) {
  if (is(words[0], "off") && words.size() == 1) {
    settings = {};
    return {};
  }
  if (std::none_of(kNames.begin(), kNames.end(), [&](auto name) { return is(words[0], name); }))
    return expected("effect", words[0],
                    "constant, spring, viscous, inertia, friction, texture, relief or off");
  EffectSettings changed = settings;
  if (const std::string refusal = read_named(words, changed); !refusal.empty())
    return "effect " + text_of(words[0]) + ": " + refusal;
  settings = changed;
  return {};
}

double effect_stiffness(std::string_view name, const EffectSettings& settings) {
  if (name == "spring" && settings.spring)
    return settings.spring->stiffness;
  if (name == "inertia" && settings.inertia)
    return settings.inertia->stiffness;
  if (name == "friction" && settings.friction)
    return settings.friction->stiffness;
  if (name == "texture" && settings.texture)
    return settings.texture->amplitude_n * 2 * std::numbers::pi / settings.texture->wavelength_m;
  return 0;
}

double effect_damping(std::string_view name, const EffectSettings& settings) {
  if (name == "viscous" && settings.viscous)
    return settings.viscous->damping;
  if (name == "inertia" && settings.inertia)
    return settings.inertia->damping;
  return 0;
}

void dump_effects(const EffectSettings& now, Host& host) {
  if (now.constant)
    host.info({"effect", "constant", now.constant->force_n.x, now.constant->force_n.y,
               now.constant->force_n.z});
  if (now.spring)
    host.info({"effect", "spring", now.spring->stiffness, now.spring->centre.x * 1e3,
               now.spring->centre.y * 1e3, now.spring->centre.z * 1e3, now.spring->max_n});
  if (now.viscous)
    host.info({"effect", "viscous", now.viscous->damping});
  if (now.inertia)
    host.info(
        {"effect", "inertia", now.inertia->mass_kg, now.inertia->stiffness, now.inertia->damping});
  if (now.friction)
    host.info({"effect", "friction", now.friction->force_n, now.friction->stiffness});
  const auto grating = [&host](std::string_view name, double height, double wavelength_m,
                               const Vec3& d) {
    host.info({"effect", name, height, wavelength_m * 1e3, d.x, d.y, d.z});
  };
  if (now.texture)
    grating("texture", now.texture->amplitude_n, now.texture->wavelength_m, now.texture->direction);
  if (now.relief)
    grating("relief", now.relief->depth_m * 1e3, now.relief->wavelength_m, now.relief->direction);
}

} // namespace tactus::phantom
