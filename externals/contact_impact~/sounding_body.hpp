#pragma once

#include "core/contact/excited_body.hpp"
#include "core/dsp/elementary.hpp"
#include "core/dsp/seam.hpp"
#include "core/dsp/soft_clip.hpp"
#include "core/object.hpp"
#include "core/refusal.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>
#include <string>
#include <vector>

/// The body of [contact_impact~] and [contact_friction~]: modes with one contact point and one
/// pickup, and the messages that describe them.
namespace tactus::contact {

inline constexpr std::size_t kMaxModes = 64;
inline constexpr double kMaxGain = 100;
inline constexpr ModeRanges kModeRanges{1, 20000, 1e-3, 1000, -kMaxGain, kMaxGain};

/// The messages, in the order in which both objects declare them first.
inline constexpr Message kModesMessage{
    "modes", "f1 t1 g1 f2 t2 g2 ... or none", 1, 3 * kMaxModes,
    "modes of the body: frequency in Hz, decay time T60 in s, and gain (displacement of the mode "
    "at the contact point); none: a silent rigid wall"};
inline constexpr Message kPickupMessage{
    "pickup", "[g1 g2 ...]", 0, kMaxModes,
    "gains of the modes at the pickup; without numbers as at the contact point"};

/// The box's positional argument: the body.
inline constexpr std::array kBodyArguments{CreationArgument{"modes"}};

/// Samples of a part of a block, in the core's precision.
using ChunkBuffer = std::array<double, 64>;

class SoundingBody : public ExcitedBody {
public:
  /// Initially a wooden bar supported at its nodes.
  SoundingBody() : ExcitedBody(kMaxModes, 1, 1) {
    modes_ = {{{330, 0.6, 1}, {910, 0.3, 1}, {1784, 0.16, 1}, {2949, 0.1, 1}}};
    update_body();
  }

  void prepare(double sample_rate) {
    ExcitedBody::prepare(sample_rate);
    seam_.prepare(sample_rate);
    smoothing_ = 1 - math::exp(-1 / (kGainTime * sample_rate));
  }
  void reset() noexcept {
    ExcitedBody::reset();
    seam_.cut();
  }
  /// Gain of the sound; changes are smoothed while the body sounds.
  void set_gain(double gain) noexcept { gain_ = gain; }
  [[nodiscard]] double gain() const noexcept { return gain_; }
  /// Converts a velocity of the body to the sound, within +-1.
  template <class S>
  void make_sound(std::span<const double> velocity, std::span<S> sound) noexcept {
    for (std::size_t n = 0; n < sound.size(); ++n) {
      if (!seam_.sounds())
        smooth_gain_ = gain_;
      smooth_gain_ += smoothing_ * (gain_ - smooth_gain_);
      sound[n] = static_cast<S>(soft_clip(smooth_gain_ * seam_.next(velocity[n])));
    }
  }

  void set_mass(double kg) noexcept {
    if (kg == mass_kg_)
      return;
    mass_kg_ = kg;
    update_body();
  }
  [[nodiscard]] double mass() const noexcept { return mass_kg_; }

  void parse_modes(std::span<const Atom> words, Host& host) {
    std::vector<ListedMode> modes;
    if (words.size() == 1 && words[0].is_word && words[0].word == "none")
      words = {};
    if (const Sentence error = modes_refusal(words, kModeRanges); !error.empty())
      return host.error(error);
    for (std::size_t i = 0; i < words.size(); i += 3)
      modes.push_back({words[i].number, words[i + 1].number, words[i + 2].number});
    modes_ = std::move(modes);
    pickup_.clear();
    update_body();
  }
  void parse_pickup(std::span<const Atom> words, Host& host) {
    std::vector<double> pickup;
    for (const Atom& word : words)
      if (is_number(word, -kMaxGain, kMaxGain))
        pickup.push_back(word.number);
    if (pickup.size() != words.size())
      return host.error(refusal("pickup", words, "gains in -100..100"));
    pickup_ = std::move(pickup);
    update_body();
  }
  /// Sends "modes f t g ...", "steps n" and "energy J" to the info outlet.
  void post_info(Host& host) const {
    std::vector<Atom> list{"modes"};
    for (const ListedMode& m : modes_)
      list.insert(list.end(), {m.frequency_hz, m.t60_s, m.gain});
    host.info(list);
    host.info({"steps", static_cast<double>(steps())});
    host.info({"energy", std::min(energy(), 1e30)});
  }

private:
  struct ListedMode {
    double frequency_hz, t60_s, gain;
  };
  static bool is_number(const Atom& word, double low, double high) {
    return !word.is_word && word.number >= low && word.number <= high;
  }
  /// Every mode has the body's mass; its gain is its shape at the contact point.
  void update_body() noexcept {
    std::array<Mode, kMaxModes> modes;
    std::array<double, kMaxModes> contact_shape{}, output{};
    for (std::size_t i = 0; i < modes_.size(); ++i) {
      modes[i] = {modes_[i].frequency_hz, modes_[i].t60_s, mass_kg_};
      contact_shape[i] = modes_[i].gain;
      output[i] = pickup_.empty() ? modes_[i].gain : i < pickup_.size() ? pickup_[i] : 0.0;
    }
    set_modes(std::span(modes).first(modes_.size()));
    set_contact_shape(0, contact_shape);
    set_pickup(0, output);
    seam_.cut();
  }

  static constexpr double kGainTime = 0.01; // s
  double mass_kg_ = 0.3;
  Seam seam_; // fades between the old and the new body while it sounds
  double gain_ = 0, smooth_gain_ = 0, smoothing_ = 1;
  std::vector<ListedMode> modes_;
  std::vector<double> pickup_;
};

} // namespace tactus::contact
