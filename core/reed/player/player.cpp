#include "core/reed/player/player.hpp"

#include "core/reed/bore/brass.hpp"
#include "core/reed/instrument/tuning.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kRiseTime = 3e-3, kFallTime = 60e-3; // s, of the breath that lips follow
constexpr double kAboveNatural = 1.012; // of a tube's mode: where blown-open lips sound it
constexpr double kStop = 50e-3;         // s without air, of a note begun anew

constexpr double kNoBreath = 10;        // Pa
constexpr double kBurstNote = 220;      // Hz, for which Parameters::tongue stands
constexpr double kSmallestBurst = 0.02; // lets the breath go, no more
constexpr double kLargestBurst = 3;     // as the parameter's own limit

/// Whether notes need the same length and lips with both.
bool same_notes(const Parameters& a, Parameters b) {
  b.gain = a.gain;
  b.played_gain = a.played_gain;
  b.tongue = a.tongue;
  b.steepening = a.steepening;
  b.breath_noise = a.breath_noise;
  b.seed = a.seed;
  b.brassiness = a.brassiness;
  b.bell = a.bell;
  b.bell_quality = a.bell_quality;
  b.ear = a.ear;
  b.fingering = a.fingering;
  b.lowest_note = a.lowest_note;
  b.highest_note = a.highest_note;
  return a == b;
}

} // namespace

void Player::prepare(double sample_rate) noexcept {
  rise_ = 1 - std::exp(-Ear::kPeriod / (kRiseTime * sample_rate));
  fall_ = 1 - std::exp(-Ear::kPeriod / (kFallTime * sample_rate));
  tongue_.prepare(sample_rate);
  ear_.prepare(sample_rate);
}

void Player::set(const Parameters& parameters, const BoreDesign& bore) noexcept {
  if (!same_notes(parameters_, parameters)) {
    lengths_.set(parameters);
    ear_.forget();
  }
  parameters_ = parameters;
  bore_ = bore;
  due_ = true;
}

void Player::reset() noexcept {
  ear_.reset();
  note_ = 0;
  breath_ = kSoftest;
  tongue_.reset();
  tries_ = 0;
  due_ = true;
}

const Player::Hold& Player::control(double bore_frequency, double reed_frequency,
                                    double mouth_pressure) noexcept {
  hold_.valve_changed = false;
  if (listens_)
    ear_.hear();
  const bool moved = !(bore_frequency == bore_frequency_); // true also for a first NaN
  const double played = note_;
  if (moved)
    bore_frequency_ = bore_frequency > 0 && bore_frequency < 1e9 ? bore_frequency : 0;
  if (moved || due_)
    choose(reed_frequency);
  else if (listens_)
    ear_.mean(note_);
  if (mouth_pressure >= 0 && mouth_pressure < kNoBreath)
    ear_.pardon();
  if (listens_ && ear_.lost() && tries_ < kTries)
    begin_anew(reed_frequency);
  if (plays_ && follow_breath(mouth_pressure))
    hold_valve();
  tongue_.set_burst(mouth_pressure >= 0 ? burst()
                                        : 0); // no breath to follow: none begins by itself
  const bool another = note_ != played || due_;
  if (another || moved || listens_)
    set_trim(listens_ ? ear_.trim() : 0, another);
  due_ = false;
  return hold_;
}

/// The note, or what is played in place of one that is refused.
double Player::playable(double frequency) noexcept {
  const double quarter_tone = std::exp2(1.0 / 24);
  const double lowest = parameters_.lowest_note, highest = parameters_.highest_note;
  const bool low = frequency * quarter_tone < lowest;
  if (!low && !(highest > 0 && frequency > highest * quarter_tone)) {
    refuses_ = false;
    return frequency;
  }
  // Once for each note: a glide through many is one.
  const bool told = refuses_ && std::abs(frequency - refusal_.note) < Ear::kLeap * refusal_.note;
  refusal_.note = frequency;
  refusal_.count += told ? 0 : 1;
  refuses_ = true;
  return note_ > 0 ? note_ : low ? lowest : highest;
}

/// Length and lips for f_b.
void Player::choose(double reed_frequency) noexcept {
  const double meant = note_of(parameters_, bore_frequency_);
  double f = std::clamp(meant, BoreDesign::kLowestFrequency, BoreDesign::kHighestFrequency);
  const bool played = plays_;
  plays_ =
      parameters_.tune && (meant > 0 || holes_ != nullptr) && !(parameters_.length_override > 0);
  listens_ = plays_ && parameters_.ear && holes_ == nullptr;
  if (plays_ && holes_ != nullptr) {
    hold_holes();
    if (due_ || !played)
      hold_valve();
  } else if (plays_) {
    f = playable(f);
    const bool leap = !(std::abs(f - note_) < Ear::kLeap * note_);
    if (leap)
      tries_ = 0;
    note_ = f;
    if (listens_)
      ear_.mean(f);
    finger(f, leap);
    const double held = held_tube();
    if (held > 0) {
      // The lips' wish is f_b; what sounds is the tube's.
      const double natural = nearest_natural(parameters_, *hold_.end, held, f);
      note_ = f = natural > 0 ? kAboveNatural * natural : f;
      listens_ = false;
    }
    const Playing lips = player_lips(parameters_, f);
    hold_.length = held > 0 ? held : lengths_.length(f, reed_frequency, leap, fingering_);
    own_scale_ = lips.reed_scale;
    if (due_ || !played || parameters_.embouchure > 0 || parameters_.embouchure_slope != 0) {
      lips_ = lips.valve;
      hold_valve();
    }
  } else {
    note_ = 0;
    own_scale_ = 1;
    hold_.end = nullptr;
    hold_.vent = 0;
    fingering_ = {};
    hold_.valve = parameters_;
    hold_.valve_changed = true;
    hold_.length = parameters_.length_override > 0 ? parameters_.length_override
                   : bore_frequency_ > 0           ? bore_.length_for(f)
                                                   : parameters_.length;
  }
  hold_.length = std::clamp(hold_.length, 5e-3, bore_.longest());
}

/// Length of the tube with the valves or the slide position that are set, m; 0: the player chooses.
double Player::held_tube() const noexcept {
  const BrassTube* const tube = brass_tube(parameters_.end);
  if (tube == nullptr || hold_.end == nullptr)
    return 0;
  if (!tube->has_valves)
    return parameters_.slide > 0 ? slide_length(*tube, *hold_.end, parameters_.slide) : 0;
  return parameters_.valves >= 0
             ? valve_length(*tube, *hold_.end, static_cast<unsigned>(parameters_.valves))
             : 0;
}

/// The fingering for f_b. A bend or a vibrato of nearly a semitone stays on the one there is.
void Player::finger(double frequency, bool leap) noexcept {
  constexpr double kBend = 0.8; // semitones
  const bool stays =
      !leap && fingered_for_ == parameters_.end && fingering_.end != nullptr &&
      std::abs(69 + 12 * std::log2(frequency / 440) - key_of(parameters_, fingering_)) < kBend;
  if (!stays)
    fingering_ = standard_fingering(parameters_, frequency);
  hold_.end = fingering_.end;
  hold_.vent = fingering_.vented ? 1 : 0;
  fingered_for_ = parameters_.end;
}

/// Line and lips for holes fingered one by one. An instrument's holes are where its standard
/// fingerings are in tune at its own f_r, with the reed's compliance and swept volume: the line to
/// the first open hole is as long as the note needs that opens all from there on.
void Player::hold_holes() noexcept {
  note_ = 440 * std::exp2((holes_->key - 69) / 12.0);
  lips_ = player_lips(parameters_, note_).valve;
  own_scale_ = 1;
  hold_.end = holes_;
  hold_.length = lengths_.length(note_, parameters_.reed_frequency, true,
                                 {fingering_for(parameters_.end, note_), false});
  hold_.vent = holes_vent_;
  fingering_ = {};
  tries_ = 0;
}

/// The note as one that has not been glided to, and from silence.
void Player::begin_anew(double reed_frequency) noexcept {
  ++tries_;
  tongue_.articulate(kStop);
  ear_.start_over();
  finger(note_, true);
  hold_.length =
      std::clamp(lengths_.length(note_, reed_frequency, true, fingering_), 5e-3, bore_.longest());
  set_trim(0, true);
}

/// By how much of p_m the tongue's push exceeds it, for this note and breath.
double Player::burst() const noexcept {
  if (!(parameters_.tongue > 0) || !(note_ > 0))
    return 0;
  const double lower = kBurstNote / note_;
  const double push = std::sqrt(lower) *
                      (parameters_.embouchure > 0 ? 1 : lower / std::sqrt(breath_)) *
                      parameters_.tongue;
  return std::clamp((1 + push) * firmness_ - 1, kSmallestBurst, kLargestBurst);
}

/// Whether that changes the lips.
bool Player::follow_breath(double mouth_pressure) noexcept {
  constexpr double kSteady = 1e-4; // a hundredth of a decibel is nothing to follow
  if (!(parameters_.breath_reference > 0) || !(mouth_pressure >= 0)) {
    const bool followed = breath_ != 1;
    breath_ = 1;
    return followed;
  }
  const double target =
      std::clamp(mouth_pressure / parameters_.breath_reference, kSoftest, kLoudest);
  if (std::abs(target - breath_) < kSteady * breath_)
    return false;
  breath_ += (target > breath_ ? rise_ : fall_) * (target - breath_);
  return true;
}

/// The lips at this breath.
void Player::hold_valve() noexcept {
  hold_.valve = lips_;
  hold_.valve_changed = true;
  firmness_ = 1;
  if (breath_ == 1)
    return;
  firmness_ = std::pow(breath_, parameters_.breath_opening + parameters_.breath_tension - 1);
  hold_.valve.rest_angle *= std::pow(breath_, parameters_.breath_opening);
  hold_.valve.mass *= std::pow(breath_, parameters_.breath_tension);
  hold_.valve.quality *= std::pow(breath_, parameters_.breath_quality);
}

/// Plays sharper by exp(logarithm): the bore shorter, the lips tighter where they are the player's
/// to choose. A change that nobody hears is left out, for a bore at rest is cheaper.
void Player::set_trim(double logarithm, bool moved) noexcept {
  constexpr double kInaudible = 1e-4; // 0.17 cents
  if (!moved && std::abs(logarithm - hold_.trim) < kInaudible && logarithm != 0)
    return;
  hold_.trim = logarithm;
  hold_.reed_scale = parameters_.embouchure > 0 ? own_scale_ * std::exp(logarithm) : own_scale_;
}

} // namespace tactus::reed
