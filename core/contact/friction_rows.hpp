#pragma once

#include "core/contact/friction.hpp"
#include "core/rows.hpp"

#include <array>

/// The numbers of FrictionLaw, a row each, in the order in which messages give them.
namespace tactus::contact {

inline constexpr std::array kFrictionRows{
    member<&FrictionLaw::static_coefficient>.row(
        "static", "", 0.001, 10, "friction coefficient at rest; below dynamic it counts as that"),
    member<&FrictionLaw::dynamic_coefficient>.row("dynamic", "", 0.001, 10,
                                                  "friction coefficient of fast sliding"),
    member<&FrictionLaw::stribeck_m_per_s>.row("stribeck", "m/s", 1e-4, 10,
                                               "how fast it slides when it has let go"),
    member<&FrictionLaw::breakaway>.row("breakaway", "", 0.01, 0.99,
                                        "share of the sliding force up to which it only bends"),
    member<&FrictionLaw::stiffness_n_per_m>.row("stiffness", "N/m", 10, 1e9,
                                                "sigma0 of the bristles"),
    member<&FrictionLaw::damping_ns_per_m>.row("damping", "N s/m", 0, 1e6,
                                               "sigma1 of the bristles"),
    member<&FrictionLaw::viscosity_ns_per_m>.row("viscosity", "N s/m", 0, 1e4,
                                                 "sigma2, as of a grease"),
    member<&FrictionLaw::roughness>.row("roughness", "", 0, 100,
                                        "random force, times sqrt(normal force times speed)"),
};

} // namespace tactus::contact
