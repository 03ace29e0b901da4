#include "core/reed/player/player.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/bore/brass.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kRiseTime = 3e-3, kFallTime = 60e-3; // s, smoothing of the breath ratio r
constexpr double kAboveNatural = 1.012;  // pitch of blown-open lips relative to the tube's mode
constexpr double kRetryStopTime = 50e-3; // s without air before a retry
constexpr double kSoftStopTime = 0.12;   // s without air before a soft retry, in which the other
                                         // register has to fade
// Number of periods for which every other retry begins softly. At a third of the pressure the
// lowest register of an oboe's lowest keys grows alone; at a high pressure the next register is
// faster.
constexpr double kSoftPeriods = 40;

constexpr double kNoBreath = 10;        // Pa
constexpr double kBurstNote = 220;      // Hz, reference note of Parameters::tongue
constexpr double kSmallestBurst = 0.02; // below it, a release has no audible push
constexpr double kLargestBurst = 3;     // the limit of the parameter

/// True if both sets of parameters give the same lengths and lips for notes.
bool same_note_parameters(const Parameters& a, Parameters b) {
  b.gain = a.gain;
  b.played_gain = a.played_gain;
  b.tongue = a.tongue;
  b.steepening = a.steepening;
  b.breath_noise = a.breath_noise;
  b.seed = a.seed;
  b.brassiness = a.brassiness;
  b.bell = a.bell;
  b.bell_quality = a.bell_quality;
  b.correct_pitch = a.correct_pitch;
  b.fingering = a.fingering;
  b.lowest_note = a.lowest_note;
  b.highest_note = a.highest_note;
  return a == b;
}

} // namespace

void Player::prepare(double sample_rate) noexcept {
  rise_gain_ = 1 - math::exp(-TuningController::kPeriod / (kRiseTime * sample_rate));
  fall_gain_ = 1 - math::exp(-TuningController::kPeriod / (kFallTime * sample_rate));
  tongue_.prepare(sample_rate);
  tuning_controller_.prepare(sample_rate);
}

void Player::set(const Parameters& parameters, const BoreDesign& bore) noexcept {
  if (!same_note_parameters(parameters_, parameters)) {
    lengths_.set(parameters, can_interpolate(parameters_, parameters));
    tuning_controller_.clear_corrections();
  }
  parameters_ = parameters;
  bore_ = bore;
  update_due_ = true;
}

void Player::reset() noexcept {
  tuning_controller_.reset();
  note_ = 0;
  breath_ = kMinBreathRatio;
  tongue_.reset();
  attempts_ = 0;
  update_due_ = true;
}

const Player::Configuration& Player::control(double bore_frequency, double reed_frequency,
                                             double mouth_pressure) noexcept {
  configuration_.valve_changed = false;
  if (tracks_pitch_)
    tuning_controller_.update();
  const bool moved = !(bore_frequency == bore_frequency_); // true also for a first NaN
  const double played = note_;
  if (moved)
    bore_frequency_ = bore_frequency > 0 && bore_frequency < 1e9 ? bore_frequency : 0;
  if (moved || update_due_)
    choose_configuration(reed_frequency);
  else if (tracks_pitch_)
    tuning_controller_.set_target(note_);
  if (mouth_pressure >= 0 && mouth_pressure < kNoBreath)
    tuning_controller_.clear_off_target();
  if (tracks_pitch_ && tuning_controller_.wrong_register() && attempts_ < kMaxAttempts)
    retry_note(reed_frequency);
  if (plays_ && follow_breath(mouth_pressure))
    update_lips();
  tongue_.set_burst(mouth_pressure >= 0 ? burst() : 0);
  const bool note_changed = note_ != played || update_due_;
  if (note_changed || moved || tracks_pitch_)
    set_trim(tracks_pitch_ ? tuning_controller_.trim() : 0, note_changed);
  update_due_ = false;
  return configuration_;
}

/// The note, or the note that is played instead when this one is refused.
double Player::accept_note(double frequency) noexcept {
  const double quarter_tone = math::exp2(1.0 / 24);
  const double lowest = parameters_.lowest_note, highest = parameters_.highest_note;
  const bool low = frequency * quarter_tone < lowest;
  if (!low && !(highest > 0 && frequency > highest * quarter_tone)) {
    refusing_ = false;
    return frequency;
  }
  // A refused note is counted once; a glide counts as one note.
  const bool already_counted =
      refusing_ && std::abs(frequency - refusal_.note) < TuningController::kMinLeap * refusal_.note;
  refusal_.note = frequency;
  refusal_.count += already_counted ? 0 : 1;
  refusing_ = true;
  return note_ > 0 ? note_ : low ? lowest : highest;
}

/// Chooses length and lips for f_b.
void Player::choose_configuration(double reed_frequency) noexcept {
  const double requested = note_of(parameters_, bore_frequency_);
  double f = std::clamp(requested, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
  const bool played = plays_;
  plays_ = parameters_.tune && (requested > 0 || holes_ != nullptr) &&
           !(parameters_.length_override > 0);
  tracks_pitch_ = plays_ && parameters_.correct_pitch && holes_ == nullptr;
  if (plays_ && holes_ != nullptr) {
    use_open_holes();
    if (update_due_ || !played)
      update_lips();
  } else if (plays_) {
    f = accept_note(f);
    const bool leap = !(std::abs(f - note_) < TuningController::kMinLeap * note_);
    if (leap)
      attempts_ = 0;
    note_ = f;
    if (tracks_pitch_)
      tuning_controller_.set_target(f);
    finger(f, leap);
    const double fixed_length = fixed_tube_length();
    if (fixed_length > 0) {
      // The lips aim at f_b; the tube's nearest mode sounds.
      const double natural = nearest_natural(parameters_, *configuration_.end, fixed_length, f);
      note_ = f = natural > 0 ? kAboveNatural * natural : f;
      tracks_pitch_ = false;
    }
    const PlayingSetup lips = player_lips(parameters_, f);
    configuration_.length =
        fixed_length > 0 ? fixed_length : lengths_.length(f, reed_frequency, leap, fingering_);
    note_reed_scale_ = lips.reed_scale;
    if (update_due_ || !played || parameters_.embouchure > 0 || parameters_.embouchure_slope != 0) {
      lips_ = lips.valve;
      update_lips();
    }
  } else {
    note_ = 0;
    note_reed_scale_ = 1;
    configuration_.end = nullptr;
    configuration_.vent = 0;
    fingering_ = {};
    configuration_.valve = parameters_;
    configuration_.valve_changed = true;
    configuration_.length = parameters_.length_override > 0 ? parameters_.length_override
                            : bore_frequency_ > 0           ? bore_.length_for(f)
                                                            : parameters_.length;
  }
  configuration_.length = std::clamp(configuration_.length, 5e-3, bore_.max_length());
}

/// Length of the tube for the valves or slide position that are set, m; 0: the player chooses.
double Player::fixed_tube_length() const noexcept {
  const BrassTube* const tube = brass_tube(parameters_.end);
  if (tube == nullptr || configuration_.end == nullptr)
    return 0;
  if (!tube->has_valves)
    return parameters_.slide > 0 ? slide_length(*tube, *configuration_.end, parameters_.slide) : 0;
  return parameters_.valves >= 0
             ? valve_length(*tube, *configuration_.end, static_cast<unsigned>(parameters_.valves))
             : 0;
}

/// Chooses the fingering for f_b. Bends and vibrato within kBend keep the present fingering.
void Player::finger(double frequency, bool leap) noexcept {
  constexpr double kBend = 0.8; // semitones
  const bool keep_fingering =
      !leap && fingering_end_ == parameters_.end && fingering_.end != nullptr &&
      std::abs(69 + 12 * math::log2(frequency / 440) - key_of(parameters_, fingering_)) < kBend;
  if (!keep_fingering)
    fingering_ = standard_fingering(parameters_, frequency);
  configuration_.end = fingering_.end;
  configuration_.vent = fingering_.vented ? 1 : 0;
  fingering_end_ = parameters_.end;
}

/// Sets length and lips for holes fingered one by one. Holes are placed so that the standard
/// fingerings are in tune at the instrument's own f_r, including the reed's compliance and swept
/// volume. The length to the first open hole is therefore that of the note whose standard fingering
/// opens all holes from there on.
void Player::use_open_holes() noexcept {
  note_ = 440 * math::exp2((holes_->key - 69) / 12.0);
  lips_ = player_lips(parameters_, note_).valve;
  note_reed_scale_ = 1;
  configuration_.end = holes_;
  configuration_.length = lengths_.length(note_, parameters_.reed_frequency, true,
                                          {fingering_for(parameters_.end, note_), false});
  configuration_.vent = holes_vent_;
  fingering_ = {};
  attempts_ = 0;
}

/// Starts the note again from silence, as after a leap.
void Player::retry_note(double reed_frequency) noexcept {
  ++attempts_;
  const double soft = attempts_ % 2 == 1 ? kSoftPeriods / note_ : 0;
  const double stop = soft > 0 ? kSoftStopTime : kRetryStopTime;
  tongue_.articulate(stop, soft);
  tuning_controller_.restart_note(stop + (soft > 0 ? soft + Tongue::kSoftRise : 0));
  finger(note_, true);
  configuration_.length = std::clamp(lengths_.length(note_, reed_frequency, true, fingering_), 5e-3,
                                     bore_.max_length());
  set_trim(0, true);
}

/// Excess of the tongue's push over p_m, relative, for this note and breath.
double Player::burst() const noexcept {
  if (!(parameters_.tongue > 0) || !(note_ > 0))
    return 0;
  const double frequency_ratio = kBurstNote / note_;
  const double excess = std::sqrt(frequency_ratio) *
                        (parameters_.embouchure > 0 ? 1 : frequency_ratio / std::sqrt(breath_)) *
                        parameters_.tongue;
  return std::clamp((1 + excess) * relative_closing_pressure_ - 1, kSmallestBurst, kLargestBurst);
}

/// Updates r from the mouth pressure, Pa; true when it has changed.
bool Player::follow_breath(double mouth_pressure) noexcept {
  constexpr double kSteady = 1e-4; // relative; smaller differences are ignored
  if (!(parameters_.breath_reference > 0) || !(mouth_pressure >= 0)) {
    const bool followed = breath_ != 1;
    breath_ = 1;
    return followed;
  }
  const double target =
      std::clamp(mouth_pressure / parameters_.breath_reference, kMinBreathRatio, kMaxBreathRatio);
  if (std::abs(target - breath_) < kSteady * breath_)
    return false;
  breath_ += (target > breath_ ? rise_gain_ : fall_gain_) * (target - breath_);
  return true;
}

/// Sets the lips for the present r.
void Player::update_lips() noexcept {
  configuration_.valve = lips_;
  configuration_.valve_changed = true;
  relative_closing_pressure_ = 1;
  if (breath_ == 1)
    return;
  relative_closing_pressure_ =
      math::pow(breath_, parameters_.breath_opening + parameters_.breath_tension - 1);
  configuration_.valve.rest_angle *= math::pow(breath_, parameters_.breath_opening);
  configuration_.valve.mass *= math::pow(breath_, parameters_.breath_tension);
  configuration_.valve.quality *= math::pow(breath_, parameters_.breath_quality);
}

/// Trims the pitch by exp(logarithm): by the bore, and by the lips if they follow the note.
/// Inaudible changes are skipped, because a constant bore is cheaper to compute.
void Player::set_trim(double logarithm, bool moved) noexcept {
  constexpr double kInaudible = 1e-4; // 0.17 cents
  if (!moved && std::abs(logarithm - configuration_.trim) < kInaudible && logarithm != 0)
    return;
  configuration_.trim = logarithm;
  configuration_.reed_scale =
      parameters_.embouchure > 0 ? note_reed_scale_ * math::exp(logarithm) : note_reed_scale_;
}

} // namespace tactus::reed
