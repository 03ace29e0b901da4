#pragma once

#include "core/reed/playability/playability_follower.hpp"
#include "core/rows.hpp"

#include <array>
#include <string_view>

/// One row for each number of PlayabilityParameters.
namespace tactus::reed {

inline constexpr std::array<std::string_view, 2> kPlayabilityModes{"paper", "robust"};
inline constexpr std::array kPlayabilityRows{
    member<&PlayabilityParameters::attack_s>.milli().row("attack", "ms", 0.1, 5000,
                                                         "rise time constant of the envelope"),
    member<&PlayabilityParameters::release_s>.milli().row("release", "ms", 0.1, 5000,
                                                          "fall time constant of the envelope"),
    member<&PlayabilityParameters::highpass_hz>.row(
        "hp", "Hz", 0.1, 1000, "cut-off of the high-pass that removes the valve's rest angle"),
    member<&PlayabilityParameters::reference_rad>.row("ref", "rad", 1e-6, 10,
                                                      "amplitude at which playability is one half"),
    member<&PlayabilityParameters::window_s>.milli().row(
        "window", "ms", 5, 250, "window in which zero crossings are counted"),
    member<&PlayabilityParameters::hysteresis>.row(
        "hyst", "", 0, 0.9, "hysteresis of the zero crossings, relative to the envelope"),
};

} // namespace tactus::reed
