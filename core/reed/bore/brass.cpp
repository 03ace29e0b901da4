#include "core/reed/bore/brass.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/playability/linear_stability.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kSlideSemitones = 6;
constexpr int kHighestNatural = 16, kSkippedNatural = 7;
constexpr BrassTube kTrumpetTube{5.85e-3, 1.2e-6, 0.66, 116.54, true, 0.9, 3, 6};
constexpr BrassTube kTromboneTube{6.95e-3, 1e-5, 1.70, 58.27, false, 0.9, 3, 12};

/// Semitones by which each valve alone lowers the open tube.
constexpr std::array<int, 3> kValveSemitones{2, 1, 3};

double length_increase(double semitones) { return math::exp2(semitones / 12) - 1; }

} // namespace

const BrassTube* brass_tube(BoreEnd end) noexcept {
  return end == BoreEnd::kTrumpet    ? &kTrumpetTube
         : end == BoreEnd::kTrombone ? &kTromboneTube
                                     : nullptr;
}

bool uses_brass_tube(const Parameters& p) noexcept {
  const BrassTube* const tube = brass_tube(p.end);
  return p.tune && tube != nullptr && (p.tube || (tube->has_valves ? p.valves >= 0 : p.slide > 0));
}

Parameters with_brass_tube(const Parameters& parameters) noexcept {
  Parameters p = parameters;
  const BrassTube* const tube = brass_tube(p.end);
  if (tube == nullptr)
    return p;
  if (!uses_brass_tube(p)) {
    p.end = BoreEnd::kOpen;
    return p;
  }
  p.shape = BoreShape::kCylinder;
  p.input_radius = tube->radius;
  p.cup_volume = tube->cup_volume;
  p.length = tube->open_length;
  p.highest_mode = 0;
  p.embouchure = tube->embouchure;
  p.embouchure_slope = 0;
  p.lip_quality = tube->lip_quality;
  p.steepening = tube->steepening;
  return p;
}

BrassPositions standard_positions(const BrassTube& tube, double note) noexcept {
  BrassPositions best;
  double shortest = 1e9;
  for (int natural = 2; natural <= kHighestNatural; ++natural) {
    if (natural == kSkippedNatural)
      continue;
    const double semitones = 12 * math::log2(natural * tube.fundamental / note);
    if (semitones < -0.5)
      continue;
    if (semitones < shortest && semitones <= kSlideSemitones + 0.5) {
      shortest = semitones;
      best = {natural, semitones};
    }
  }
  if (shortest > 100) // out of the tube's range: use the nearer limit
    best.semitones = note * 2 < tube.fundamental * 4 ? kSlideSemitones : 0;
  if (tube.has_valves)
    best.semitones = std::round(best.semitones);
  best.semitones = std::clamp(best.semitones, -0.5, kSlideSemitones + 0.5);
  return best;
}

double slide_length(const BrassTube& tube, const Termination& bell, double position) noexcept {
  const double sounding = tube.open_length + bell.length_correction();
  return tube.open_length + sounding * length_increase(position - 1);
}

double valve_length(const BrassTube& tube, const Termination& bell, unsigned pressed) noexcept {
  const double sounding = tube.open_length + bell.length_correction();
  double length = tube.open_length;
  for (std::size_t valve = 0; valve < kValveSemitones.size(); ++valve)
    if ((pressed >> valve & 1) != 0)
      length += sounding * length_increase(kValveSemitones[valve]);
  return length;
}

bool within_tube_range(const BrassTube& tube, const Termination& bell, double length) noexcept {
  return length > slide_length(tube, bell, 0.5) && length < slide_length(tube, bell, 7.5);
}

double nearest_natural(const Parameters& parameters, const Termination& bell, double length,
                       double target_hz) noexcept {
  constexpr int kStarts = 9; // starts of Newton's iteration, in the octave around target_hz
  const LinearStability theory(parameters, length, &bell);
  double nearest = 0, min_interval = 1;
  for (int i = 0; i < kStarts; ++i) {
    const Mode mode = theory.bore_resonance_near(
        target_hz * math::exp2(static_cast<double>(i) / (kStarts - 1) - 0.5));
    if (!mode.found || !(mode.frequency_hz > 0))
      continue;
    const double interval = std::abs(math::log2(mode.frequency_hz / target_hz));
    if (interval < min_interval) {
      min_interval = interval;
      nearest = mode.frequency_hz;
    }
  }
  return nearest;
}

unsigned standard_valves(int semitones) noexcept {
  constexpr std::array<unsigned, 7> kPressed{0, 2, 1, 3, 6, 5, 7}; // 0 2 1 12 23 13 123
  return kPressed[static_cast<std::size_t>(std::clamp(semitones, 0, 6))];
}

} // namespace tactus::reed
