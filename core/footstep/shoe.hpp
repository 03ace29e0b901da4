#pragma once

#include "core/contact/impact.hpp"

namespace tactus::footstep {

/// The sole's own contact law, by its hardness: 0 barefoot (heel pad), 0.25 soft rubber, 0.5
/// leather, 0.75 a hard heel, 1 steel. Straight lines on logarithmic scales through forces at an
/// indentation of 1 mm of 63 N (a heel pad: 100 to 200 N/mm at some 100 N, Cavanagh 1999) and
/// 1.6e5 N (Hertz' law for steel of 2 cm radius), and through dissipations of 3 and 0.3 s/m, which
/// return 0.4 and 0.9 of a landing at 0.5 m/s. The exponent is the ground's.
[[nodiscard]] contact::ImpactLaw sole_law(double hardness, double exponent) noexcept;

/// Two laws of one exponent a in series, as one: the same force indents both,
///     d = d1 + d2 = (F/k1)^(1/a) + (F/k2)^(1/a),   k = (k1^(-1/a) + k2^(-1/a))^(-a),
/// and with shares s_i = d_i/d and to the first order in the dissipations
///     mu = s1^2 mu1 + s2^2 mu2.
/// A compliance of `ground` stays.
[[nodiscard]] contact::ImpactLaw in_series(const contact::ImpactLaw& ground,
                                           const contact::ImpactLaw& sole) noexcept;

} // namespace tactus::footstep
