#pragma once

#include "core/haptic/effects/effect_model.hpp"
#include "externals/phantom/words.hpp"

#include <functional>
#include <string>
#include <string_view>

namespace tactus::phantom {

/// Applies the words after `effect` to the settings. Returns a sentence if the words are refused;
/// the settings are then unchanged.
[[nodiscard]] std::string read_effect(Words words, haptic::EffectSettings& settings);
/// The largest stiffness and the damping of an effect; 0 if the effect has none.
struct EffectDemand {
  double stiffness_n_per_m = 0, damping_n_s_per_m = 0;
};
/// Calls `visit` with the name and the demand of each effect that is on.
void visit_demands(const haptic::EffectSettings& settings,
                   const std::function<void(std::string_view, EffectDemand)>& visit);
/// Sends one line for each effect that is on.
void dump_effects(const haptic::EffectSettings& settings, Host& host);

} // namespace tactus::phantom
