#pragma once

#include "core/reed/parameters.hpp"

namespace tactus::reed {

/// Length of the bore, m, with which the instrument's linear playing frequency is bore_frequency
/// (Hz) at that reed frequency (Hz): the neutral oscillation exp(i 2 pi f_b t) of
/// Y_in(L) = Y_valve(p_m) at the lowest pressure that has one. A blown-open valve plays a mode of a
/// longer bore: among the solutions the one nearest to the parameters' own length is taken; the
/// others play their lowest mode. Where no pressure starts the note, the pressure counts that comes
/// nearest to it. Bounded work (about 60 evaluations of a few complex functions), no allocation.
[[nodiscard]] double tuned_length(const Parameters& parameters, double bore_frequency,
                                  double reed_frequency) noexcept;

} // namespace tactus::reed
