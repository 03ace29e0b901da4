#include "core/reed/instrument/length_table.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

// Range of the round trip's turns over which a glide keeps its mode, relative to the instrument's
// own. It is narrower for a cone, because a cone of twice the length is wide at its end and
// resonates weakly.
constexpr double kMinTurnRatio = 0.3, kMaxTurnRatioCylinder = 2.5, kMaxTurnRatioCone = 1.6;

} // namespace

void LengthTable::set(const Parameters& parameters, bool same_mode) noexcept {
  parameters_ = parameters;
  steps_ = {};
  if (!same_mode)
    turns_.reset();
}

double LengthTable::turns_at(std::size_t step, const Fingering& fingering) noexcept {
  if (!steps_[step].computed || steps_[step].fingering != fingering) {
    const double f = kLowest * math::exp2(static_cast<double>(step) / kSteps);
    const PlayingSetup playing = tuned(parameters_, f, reed_frequency_, fingering);
    steps_[step] = {round_trip_turns(parameters_, f, playing.length), true, fingering};
  }
  return steps_[step].turns;
}

double LengthTable::length(double bore_frequency, double reed_frequency, bool leap,
                           const Fingering& fingering) noexcept {
  constexpr double kMaxReedChange = 0.01; // relative change of f_r up to which the table is kept
  if (!(parameters_.embouchure > 0) &&
      !(std::abs(reed_frequency - reed_frequency_) < kMaxReedChange * reed_frequency)) {
    steps_ = {};
    reed_frequency_ = reed_frequency;
  }
  if (const double valve_length = valve_only_length(parameters_, bore_frequency, fingering.end);
      valve_length > 0) {
    turns_ = round_trip_turns(parameters_, bore_frequency, valve_length);
    return valve_length;
  }
  const double at = std::clamp(kSteps * math::log2(bore_frequency / kLowest), 0.0,
                               static_cast<double>(kCount) - 2);
  const auto step = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(step), below = turns_at(step, fingering);
  double difference = turns_at(step + 1, fingering) - below;
  difference -= std::round(difference); // the step above may have switched to another mode
  double turns = below + share * difference;
  if (parameters_.type == ValveType::kOpen) {
    const double nominal_turns = round_trip_turns(
        parameters_, bore_frequency, nominal_length(parameters_, bore_frequency, fingering.end));
    const double nearest = turns + std::round(nominal_turns - turns);
    turns += std::round(turns_.value_or(nearest) - turns);
    const double max_ratio =
        parameters_.shape == BoreShape::kCone ? kMaxTurnRatioCone : kMaxTurnRatioCylinder;
    const bool beyond =
        fingering.end != nullptr && uses_brass_tube(parameters_)
            ? !within_tube_range(*brass_tube(parameters_.end), *fingering.end,
                                 length_from_turns(parameters_, bore_frequency, turns))
            : turns < kMinTurnRatio * nominal_turns || turns > max_ratio * nominal_turns;
    if (leap || beyond)
      turns = nearest;
  }
  turns_ = turns;
  return length_from_turns(parameters_, bore_frequency, turns);
}

} // namespace tactus::reed
