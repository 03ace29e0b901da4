#pragma once

#include "core/haptic/effects/effect_model.hpp"
#include "core/object.hpp"

#include <string>

namespace tactus::phantom {

/// Changes the settings as the words after `effect` say; a sentence when they are refused, and
/// nothing has changed then.
[[nodiscard]] std::string read_effect(std::span<const Atom> words,
                                      haptic::EffectSettings& settings);
/// Largest stiffness that the effect of that name renders, in N/m; 0 when it is off or has none.
[[nodiscard]] double effect_stiffness(std::string_view name,
                                      const haptic::EffectSettings& settings);
/// Largest damping, as asked for; 0 when it is off or has none. N s/m
[[nodiscard]] double effect_damping(std::string_view name, const haptic::EffectSettings& settings);
/// One line for each effect that is on.
void dump_effects(const haptic::EffectSettings& settings, Host& host);

} // namespace tactus::phantom
