#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <span>

namespace tactus::footstep {

/// exp(deviation * x), x normal within +-2.5: a factor that differs from step to step.
[[nodiscard]] inline double lognormal_factor(double deviation, Random& random) noexcept {
  return std::exp(deviation * std::clamp(random.normal(), -2.5, 2.5));
}

/// Gives a body the modes of a recipe, from slot `first` on in its list; `before` are those that
/// come first and are not heard. One number of `detune` a mode, standard normal.
void set_body_modes(contact::ExcitedBody& body, const ModesRecipe& modes,
                    std::span<const double> detune, double frequency, double decay,
                    std::span<const contact::Mode> before = {}) noexcept;

/// Shares of the modes in a contact at a place drawn at random, log-normal by `modes.place`.
[[nodiscard]] std::array<double, kMaxModes> draw_mode_shape(const ModesRecipe& modes,
                                                            Random& random) noexcept;

} // namespace tactus::footstep
