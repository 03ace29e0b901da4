#pragma once

#include "core/contact/impact.hpp"

namespace tactus::footstep {

/// Contact law of a sole of this hardness: 0 barefoot (heel pad), 0.25 soft rubber, 0.5 leather,
/// 0.75 a hard heel, 1 steel.
///
/// The force at 1 mm indentation is interpolated logarithmically from 63 N (heel pad: 100 to 200
/// N/mm at about 100 N, Cavanagh 1999) to 1.6e5 N (Hertz' law for steel of 2 cm radius). The
/// dissipation is interpolated from 3 to 0.3 s/m, which gives restitutions of 0.4 and 0.9 at 0.5
/// m/s. The exponent is that of the ground.
[[nodiscard]] contact::ImpactLaw sole_law(double hardness, double exponent) noexcept;

/// One law for two contacts of the same exponent a in series. The same force indents both:
///     d = d1 + d2 = (F/k1)^(1/a) + (F/k2)^(1/a),   k = (k1^(-1/a) + k2^(-1/a))^(-a).
/// With the shares s_i = d_i/d, and to first order in the dissipations,
///     mu = s1^2 mu1 + s2^2 mu2.
/// The compliance of `ground` is kept.
[[nodiscard]] contact::ImpactLaw in_series(const contact::ImpactLaw& ground,
                                           const contact::ImpactLaw& sole) noexcept;

} // namespace tactus::footstep
