#pragma once

#include "core/object.hpp"
#include "core/sentence.hpp"

#include <span>
#include <string_view>

namespace tactus {

/// The error of a message with wrong values: "jump 2: expected a height in 0.01..1 m". If the
/// values are many or long, only the first are quoted, followed by "...". Allocates nothing.
[[nodiscard]] Sentence refusal(std::string_view message, std::span<const Atom> given,
                               std::string_view expected);

/// One mode of a message `modes f1 t1 g1 f2 t2 g2 ...`, and the ranges of its three numbers.
struct ModeRanges {
  double min_frequency_hz, max_frequency_hz, min_t60_s, max_t60_s, min_gain, max_gain;
};

/// Error sentence if the values of a message `modes` are refused; empty if they are a frequency, a
/// time and a gain of each mode, in range. It names the first wrong value: "modes: time 0 s of mode
/// 2: expected 0.001..1000".
[[nodiscard]] Sentence modes_refusal(std::span<const Atom> given, const ModeRanges&);

} // namespace tactus
