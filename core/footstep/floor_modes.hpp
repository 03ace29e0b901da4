#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/elementary.hpp"
#include "core/dsp/random.hpp"
#include "core/footstep/recipe.hpp"

#include <algorithm>
#include <array>
#include <span>

namespace tactus::footstep {

/// A random factor exp(deviation * x), x normal and clamped to +-2.5: variation from step to step.
[[nodiscard]] inline double lognormal_factor(double deviation, Random& random) noexcept {
  return math::exp(deviation * std::clamp(random.normal(), -2.5, 2.5));
}

/// Sets the modes of a body to `before` followed by the modes of a recipe, and the body's pickup 0
/// to the recipe's gains; the modes in `before` have gain 0. `detune`: one standard normal number
/// per mode. `frequency`, `decay`: factors on frequencies and decay times.
void set_body_modes(contact::ExcitedBody& body, const ModesRecipe& modes,
                    std::span<const double> detune, double frequency, double decay,
                    std::span<const contact::Mode> before = {}) noexcept;

/// Mode shape of a random contact point: log-normal numbers of deviation `mode_share_scatter`.
[[nodiscard]] std::array<double, kMaxModes> draw_mode_shape(const ModesRecipe& modes,
                                                            Random& random) noexcept;

} // namespace tactus::footstep
