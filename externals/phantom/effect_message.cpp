#include "externals/phantom/effect_message.hpp"

#include "core/declaration_text.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/text.hpp"

#include <numbers>

/// The message `effect` of [phantom].
namespace tactus::phantom {
namespace {

using haptic::EffectSettings;
using haptic::Vec3;
using Words = std::span<const Atom>;

constexpr std::string_view kNames = "constant, spring, viscous, inertia, friction, texture, relief "
                                    "or off";
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
    return "direction 0 0 0: expected one that is not zero";
  direction = direction * (1 / length);
  return {};
}

} // namespace

std::string read_effect(Words words, EffectSettings& settings) {
  EffectSettings changed = settings;
  const std::string name = text_of(words[0]);
  const Words rest = words.subspan(1);
  const bool off = rest.size() == 1 && is(rest[0], "off");
  std::string refusal;
  if (is(words[0], "off") && rest.empty()) {
    changed = {};
  } else if (is(words[0], "constant")) {
    constexpr Range ranges[] = {force("fx"), force("fy"), force("fz")};
    double v[3] = {};
    if (!off)
      refusal = read_some(rest, ranges, 3, v);
    changed.constant = {{v[0], v[1], v[2]}};
    if (off)
      changed.constant.reset();
  } else if (is(words[0], "spring")) {
    constexpr Range ranges[] = {{"k", "N/m", 0, 5000},
                                millimetres("x"),
                                millimetres("y"),
                                millimetres("z"),
                                {"max", "N", 0, 40}};
    double v[5] = {0, 0, 0, 0, 40};
    if (!off)
      refusal = read_some(rest, ranges, 4, v);
    changed.spring = {v[0], metres(v + 1), v[4]};
    if (off)
      changed.spring.reset();
  } else if (is(words[0], "viscous")) {
    constexpr Range ranges[] = {{"b", "N s/m", 0, 50}};
    double v[1] = {};
    if (!off)
      refusal = read_some(rest, ranges, 1, v);
    changed.viscous = {v[0]};
    if (off)
      changed.viscous.reset();
  } else if (is(words[0], "inertia")) {
    constexpr Range ranges[] = {
        {"mass", "kg", 1e-3, 20}, {"k", "N/m", 1, 5000}, {"b", "N s/m", 0, 20}};
    const EffectSettings::Inertia usual;
    double v[3] = {0, usual.stiffness, usual.damping};
    if (!off)
      refusal = read_some(rest, ranges, 1, v);
    changed.inertia = {v[0], v[1], v[2]};
    if (off)
      changed.inertia.reset();
  } else if (is(words[0], "friction")) {
    constexpr Range ranges[] = {{"force", "N", 0, 40}, {"k", "N/m", 1, 5000}};
    double v[2] = {0, EffectSettings::Friction{}.stiffness};
    if (!off)
      refusal = read_some(rest, ranges, 1, v);
    changed.friction = {v[0], v[1]};
    if (off)
      changed.friction.reset();
  } else if (is(words[0], "texture") || is(words[0], "relief")) {
    const bool carved = is(words[0], "relief");
    const Range height = carved ? Range{"depth", "mm", 0, 10} : Range{"amplitude", "N", 0, 40};
    double v[5] = {0, 1, 1, 0, 0};
    Vec3 direction{1, 0, 0};
    if (!off)
      refusal = read_grating(rest, height, v, direction);
    if (refusal.empty() && carved && v[0] > 0.25 * v[1])
      refusal = "depth " + number_text(v[0]) +
                " mm: expected at most a quarter of the wavelength, " + number_text(0.25 * v[1]) +
                " mm";
    if (carved)
      changed.relief = {v[0] * 1e-3, v[1] * 1e-3, direction};
    else
      changed.texture = {v[0], v[1] * 1e-3, direction};
    if (off && carved)
      changed.relief.reset();
    else if (off)
      changed.texture.reset();
  } else {
    return expected("effect", words[0], kNames);
  }
  if (!refusal.empty())
    return "effect " + name + ": " + refusal;
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

namespace tactus {

void Phantom::on_effect(Words words, Host& host) {
  if (const std::string refusal = phantom::read_effect(words, effect_settings_); !refusal.empty())
    return host.error(refusal);
  rig_->effects.set(effect_settings_);
  warn_of_effect(phantom::text_of(words[0]), host);
}

void Phantom::warn_of_effect(const std::string& name, Host& host) {
  warn_of_stiffness("effect " + name, phantom::effect_stiffness(name, effect_settings_), host);
  warn_of_damping("effect " + name, phantom::effect_damping(name, effect_settings_), host);
}

} // namespace tactus
