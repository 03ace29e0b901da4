#pragma once

#include "core/haptic/effects/effect_model.hpp"
#include "core/object.hpp"

#include <string>

namespace tactus::phantom {

/// Applies the words after `effect` to the settings. Returns a sentence when they are refused; the
/// settings are then unchanged.
[[nodiscard]] std::string read_effect(std::span<const Atom> words,
                                      haptic::EffectSettings& settings);
/// Largest stiffness of the effect of that name, N/m; 0 when it is off or has none.
[[nodiscard]] double effect_stiffness(std::string_view name,
                                      const haptic::EffectSettings& settings);
/// Requested damping of the effect of that name, N s/m; 0 when it is off or has none.
[[nodiscard]] double effect_damping(std::string_view name, const haptic::EffectSettings& settings);
/// Sends one line for each effect that is on.
void dump_effects(const haptic::EffectSettings& settings, Host& host);

} // namespace tactus::phantom
