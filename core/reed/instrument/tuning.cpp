#include "core/reed/instrument/tuning.hpp"

#include "core/dsp/complex.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/bore/radiation.hpp"
#include "core/reed/bore/wall_loss.hpp"
#include "core/reed/bore/woodwind.hpp"
#include "core/reed/playability/linear_stability.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

using std::numbers::pi;
constexpr double kPlayingReeds = 1.5;    // usual ratio of mouth pressure to threshold, for reeds
constexpr double kPlayingLips = 2.5;     // the same ratio for lips
constexpr double kShortestTube = 0.05;   // m, shortest tube that lips play on
constexpr double kValveOnlyRatio = 0.75; // f_b relative to the bore's lowest resonance; below it
                                         // the valve alone sets the pitch

/// The bore with which the valve oscillates at a given frequency and mouth pressure.
struct Candidate {
  double length; // m
  double excess; // ln of the loop gain valve times bore; 0: neutral oscillation
};

/// Solves Y_in(L) = Y_valve(p_m) at one frequency for the round trip of the bore, and then finds L
/// from the round trip.
class NeutralOscillation {
public:
  NeutralOscillation(const Parameters& p, double frequency, double reed_frequency,
                     const Fingering& fingering)
      : parameters_(p), theory_(p, p.length), s_(0, 2 * pi * frequency),
        reed_frequency_(reed_frequency) {
    bore_.set_geometry(p);
    bore_.set_end(fingering.end);
    const double area = pi * p.input_radius * p.input_radius;
    const Air& air = bore_.air();
    lumped_ = s_ * p.cup_volume / (air.density * air.sound_speed * air.sound_speed);
    if (p.shape == BoreShape::kCone)
      lumped_ += area / (s_ * air.density * p.apex_distance);
    end_ = p.scalar_reflection > 0 ? Complex(-p.scalar_reflection) : bore_.end_reflection(s_);
    nominal_length_ = nominal_length(p, frequency, fingering.end);
    if (fingering.vented && !(p.scalar_reflection > 0)) {
      vent_ = RegisterVent::of(p);
      vent_round_trip_ = math::exp(-s_ * 2.0 * vent_.position / air.sound_speed -
                                   wall_loss(p, vent_.position, air.sound_speed) * math::sqrt(s_));
      // The vent selects the bore's second mode.
      nominal_length_ = bore_.length_for(frequency / (p.shape == BoreShape::kCone ? 2 : 3));
    }
  }

  [[nodiscard]] Candidate at(double mouth_pressure) const {
    const Equilibrium state = theory_.equilibrium(mouth_pressure, reed_frequency_);
    const Complex valve = theory_.valve_admittance(s_, state, reed_frequency_);
    const Complex y = bore_.impedance() * (valve - lumped_);
    Complex round_trip = (1.0 - y) / (1.0 + y);
    if (vent_.share > 0)
      round_trip = vent_.without_vent(s_, round_trip, vent_round_trip_);
    const double omega = s_.imag(), speed = bore_.air().sound_speed;
    // -omega 2L/c - G(L) sqrt(omega/2) = arg(round trip/R) - 2 pi n
    const double phase = math::arg(round_trip / end_);
    double length = nominal_length_, loss = 0;
    for (int i = 0; i < 3; ++i) {
      loss = parameters_.scalar_reflection > 0 ? 0 : wall_loss(parameters_, length, speed);
      const double friction = loss * std::sqrt(omega / 2);
      const auto length_at_turn = [&](double n) {
        return (2 * pi * n - phase - friction) * speed / (2 * omega);
      };
      const double turn = (nominal_length_ * 2 * omega / speed + phase + friction) / (2 * pi);
      length = length_at_turn(std::round(turn));
      if (length < 5e-3)
        length = length_at_turn(std::round(turn) + 1);
    }
    const double log_loss = math::log(math::abs(end_)) - loss * std::sqrt(omega / 2);
    return {length, log_loss - math::log(math::abs(round_trip))};
  }

  [[nodiscard]] double highest_pressure() const {
    return theory_.highest_pressure(reed_frequency_);
  }

private:
  const Parameters& parameters_;
  LinearStability theory_;
  BoreDesign bore_;
  Complex s_, lumped_, end_;
  double reed_frequency_, nominal_length_;
  RegisterVent vent_{};
  Complex vent_round_trip_ = 1; // round trip from the reed to the vent and back
};

double aimed_frequency(const Parameters& parameters, double bore_frequency) {
  return bore_frequency * math::exp2(parameters.aim / 1200);
}

/// f_r/f_b of lips for a note at `aimed` Hz.
double embouchure_at(const Parameters& parameters, double aimed) {
  return parameters.embouchure *
         math::pow(aimed / parameters.reed_frequency, parameters.embouchure_slope);
}

/// The player's lips for a note at `aimed` Hz, on the bore as given.
PlayingSetup lips_at(const Parameters& parameters, double aimed) {
  PlayingSetup playing{parameters, parameters.length};
  Parameters& valve = playing.valve;
  valve.mass *= parameters.lip_mass;
  valve.rest_angle *= parameters.lip_opening;
  valve.width *= parameters.lip_width;
  valve.quality *= parameters.lip_quality;
  valve.channel_length *= parameters.lip_channel;
  valve.displacement_limit *= parameters.lip_limit;
  valve.cup_volume *= parameters.lip_cup;
  if (parameters.embouchure > 0) {
    playing.reed_scale = embouchure_at(parameters, aimed) * aimed / parameters.reed_frequency;
    valve.mass /= playing.reed_scale * playing.reed_scale;
  } else {
    const double opening_factor =
        math::pow(aimed / parameters.reed_frequency, parameters.embouchure_slope);
    valve.rest_angle *= opening_factor;
    valve.mass /= opening_factor;
  }
  valve = clamped(valve);
  return playing;
}

/// Semitones by which the register vent raises a fingering's note.
int overblow_interval(const Parameters& parameters) {
  const Woodwind* const instrument = woodwind(parameters.end);
  return instrument != nullptr ? instrument->overblow_interval : 0;
}

} // namespace

Fingering standard_fingering(const Parameters& parameters, double bore_frequency) noexcept {
  const double quarter_tone = math::exp2(1.0 / 24);
  const bool vented = parameters.end != BoreEnd::kOpen && parameters.register_note > 0 &&
                      bore_frequency * quarter_tone >= parameters.register_note;
  const double fingered_frequency =
      vented ? bore_frequency * math::exp2(-overblow_interval(parameters) / 12.0) : bore_frequency;
  return {fingering_for(parameters.end, fingered_frequency), vented};
}

double key_of(const Parameters& parameters, const Fingering& fingering) noexcept {
  return fingering.end == nullptr
             ? 0
             : fingering.end->key + (fingering.vented ? overblow_interval(parameters) : 0);
}

double nominal_length(const Parameters& parameters, double bore_frequency,
                      const Termination* end) noexcept {
  BoreDesign bore;
  bore.set_geometry(parameters);
  bore.set_end(end);
  if (parameters.type != ValveType::kOpen)
    return bore.length_for(bore_frequency);
  if (end != nullptr && uses_brass_tube(parameters)) {
    const BrassTube& tube = *brass_tube(parameters.end);
    const double semitones = standard_positions(tube, bore_frequency).semitones;
    return tube.has_valves ? valve_length(tube, *end, standard_valves(static_cast<int>(semitones)))
                           : slide_length(tube, *end, 1 + semitones);
  }
  if (!(parameters.highest_mode > 0))
    return parameters.length;
  for (int above = 0; parameters.highest_mode + above < 100; ++above) {
    const double mode = parameters.highest_mode + above;
    const double quarter_waves = parameters.shape == BoreShape::kCone ? mode : 2 * mode - 1;
    const double length = bore.length_for(bore_frequency / quarter_waves);
    if (length > kShortestTube)
      return std::min(parameters.length, length);
  }
  return parameters.length;
}

double tuned_length(const Parameters& parameters, double bore_frequency, double reed_frequency,
                    double over_threshold, const Fingering& fingering) noexcept {
  constexpr int kPressures = 32;
  constexpr int kBisections = 24;
  const NeutralOscillation oscillation(parameters, bore_frequency, reed_frequency, fingering);
  const double highest = oscillation.highest_pressure();
  double low = 0;
  Candidate best{0, -1e300};
  for (int i = 1; i <= kPressures; ++i) {
    double high = highest * i / kPressures;
    Candidate candidate = oscillation.at(high);
    if (candidate.excess > best.excess)
      best = candidate;
    if (candidate.excess < 0) {
      low = high;
      continue;
    }
    for (int k = 0; k < kBisections; ++k) {
      const double middle = 0.5 * (low + high);
      candidate = oscillation.at(middle);
      (candidate.excess < 0 ? low : high) = middle;
    }
    best = oscillation.at(std::min(over_threshold * high, 0.5 * (high + highest)));
    break;
  }
  BoreDesign bore;
  bore.set_geometry(parameters);
  return std::clamp(best.length, 5e-3, bore.max_length());
}

double round_trip_turns(const Parameters& parameters, double bore_frequency,
                        double length) noexcept {
  const double omega = 2 * pi * aimed_frequency(parameters, bore_frequency);
  const double speed = air_at(parameters.temperature).sound_speed;
  const double loss = parameters.scalar_reflection > 0 ? 0 : wall_loss(parameters, length, speed);
  return (2 * omega * length / speed + loss * std::sqrt(omega / 2)) / (2 * pi);
}

double length_from_turns(const Parameters& parameters, double bore_frequency,
                         double turns) noexcept {
  const double omega = 2 * pi * aimed_frequency(parameters, bore_frequency);
  const double speed = air_at(parameters.temperature).sound_speed;
  double length = parameters.length;
  for (int i = 0; i < 6; ++i) {
    const double loss = parameters.scalar_reflection > 0 ? 0 : wall_loss(parameters, length, speed);
    length = std::max(5e-3, (2 * pi * turns - loss * std::sqrt(omega / 2)) * speed / (2 * omega));
  }
  return length;
}

double valve_only_length(const Parameters& parameters, double bore_frequency,
                         const Termination* end) noexcept {
  if (!(parameters.embouchure > 0))
    return 0;
  BoreDesign bore;
  bore.set_geometry(parameters);
  bore.set_end(end);
  const double lowest = aimed_frequency(parameters, bore_frequency) / kValveOnlyRatio;
  if (lowest <= bore.ideal_frequency(parameters.length))
    return parameters.length;
  const double raised_length = bore.length_for(lowest);
  return parameters.shortest_tract > 0 && raised_length >= parameters.shortest_tract ? raised_length
                                                                                     : 0;
}

PlayingSetup player_lips(const Parameters& parameters, double bore_frequency) noexcept {
  return lips_at(parameters, aimed_frequency(parameters, bore_frequency));
}

PlayingSetup tuned(const Parameters& parameters, double bore_frequency,
                   double reed_frequency) noexcept {
  return tuned(parameters, bore_frequency, reed_frequency,
               standard_fingering(parameters, bore_frequency));
}

PlayingSetup tuned(const Parameters& parameters, double bore_frequency, double reed_frequency,
                   const Fingering& fingering) noexcept {
  const double aimed = aimed_frequency(parameters, bore_frequency);
  PlayingSetup playing = lips_at(parameters, aimed);
  const Parameters& valve = playing.valve;
  playing.fingering = fingering;
  const double reed =
      parameters.embouchure > 0 ? embouchure_at(parameters, aimed) * aimed : reed_frequency;
  playing.length = valve_only_length(parameters, bore_frequency, fingering.end);
  if (!(playing.length > 0))
    playing.length = tuned_length(
        valve, aimed, reed, parameters.embouchure > 0 ? kPlayingLips : kPlayingReeds, fingering);
  return playing;
}

PlayingSetup embouchure_for(const Parameters& parameters, double bore_frequency,
                            double length_m) noexcept {
  PlayingSetup playing{parameters, parameters.length};
  const double requested = note_of(parameters, bore_frequency);
  if (parameters.tune && requested > 0 && !(parameters.length_override > 0)) {
    const double note =
        std::clamp(requested, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
    playing = player_lips(parameters, note);
    playing.fingering = standard_fingering(parameters, note);
  }
  playing.length = length_m;
  return playing;
}

} // namespace tactus::reed
