#pragma once

#include "core/contact/friction.hpp"
#include "core/rows.hpp"

#include <array>

/// A row for each number of FrictionLaw, in the order in which messages give the numbers.
namespace tactus::contact {

inline constexpr std::array kFrictionRows{
    member<&FrictionLaw::static_coefficient>.row("static", "", 0.001, 10,
                                                 "static friction coefficient; at least `dynamic`"),
    member<&FrictionLaw::dynamic_coefficient>.row("dynamic", "", 0.001, 10,
                                                  "dynamic friction coefficient"),
    member<&FrictionLaw::stribeck_m_per_s>.row(
        "stribeck", "m/s", 1e-4, 10,
        "Stribeck velocity: sliding speed above which friction falls to `dynamic`"),
    member<&FrictionLaw::breakaway>.row(
        "breakaway", "", 0.01, 0.99,
        "share of the dynamic friction force below which bristles only bend"),
    member<&FrictionLaw::stiffness_n_per_m>.row("stiffness", "N/m", 10, 1e9,
                                                "bristle stiffness sigma0"),
    member<&FrictionLaw::damping_ns_per_m>.row("damping", "N s/m", 0, 1e6,
                                               "bristle damping sigma1"),
    member<&FrictionLaw::viscosity_ns_per_m>.row("viscosity", "N s/m", 0, 1e4,
                                                 "viscous friction sigma2, as by a lubricant"),
    member<&FrictionLaw::roughness>.row(
        "roughness", "", 0, 100, "random friction force divided by sqrt(normal force times speed)"),
};

} // namespace tactus::contact
