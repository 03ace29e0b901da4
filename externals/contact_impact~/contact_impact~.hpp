#pragma once

#include "core/contact/strike_scatter.hpp"
#include "core/dsp/random.hpp"
#include "core/object.hpp"
#include "core/refusal.hpp"
#include "externals/contact_impact~/sounding_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus {
namespace contact_impact {

inline constexpr contact::ImpactLaw kLaw{};

enum ParameterIndex : std::size_t {
  kMass,
  kStiffness,
  kExponent,
  kDissipation,
  kGravity,
  kBody,
  kGain,
  kVariation,
  kSeed,
};
inline constexpr std::array kParameters{
    Parameter{"mass", "kg", 0.02, 1e-5, 1000, "of what strikes"},
    Parameter{"stiffness", "N/m^exponent", kLaw.stiffness, 1, 1e16, "k of the contact"},
    Parameter{"exponent", "", kLaw.exponent, 1, 4, "1: a spring, 1.5: round bodies, above: felt"},
    Parameter{"dissipation", "s/m", kLaw.dissipation_s_per_m, 0, 1000,
              "mu of the contact: what is lost grows with mu times the speed"},
    Parameter{"gravity", "m/s^2", 0, 0, 1000, "draws the mass towards the body"},
    Parameter{"body", "kg", 0.3, 1e-4, 1e5, "modal mass of every mode of gain 1"},
    Parameter{"gain", "s/m", 5, 0, 1e5, "of the sound: times the body's velocity"},
    Parameter{"variation", "", 0, 0, 1,
              "of strikes: 1 scatters their speed as a hand does, 0 repeats it"},
    seed_parameter<"seed of the variation">(),
};

enum MessageIndex : std::size_t { kModes, kPickup, kStrike, kBang, kDrop, kReset };
inline constexpr std::array kMessages{
    contact::kModesMessage,
    contact::kPickupMessage,
    realtime(
        Message{"strike", "v", 1, 1, "the mass meets the body with v m/s; 0: it is laid on it"}),
    realtime(Message{"bang", "", 0, 0, "the last strike or drop again"}),
    realtime(Message{"drop", "h", 1, 1, "the mass falls h mm, with gravity above 0"}),
    realtime(Message{"reset", "", 0, 0, "silence, the mass 1 m away"}),
};

inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "force", "N", "pushes the mass into the body"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "sound", "", "velocity of the body times gain, within +-1"},
    Port{Port::Kind::kSignal, "contact", "N", "force between mass and body"},
    Port{Port::Kind::kControl, "impact", "", "after each contact: duration in ms, impulse in N s"},
};

} // namespace contact_impact

/// [contact_impact~]: a mass strikes a body of some modes (core/contact/excited_body.hpp).
class ContactImpact {
public:
  static constexpr Declaration declaration{
      "contact_impact~",
      "a mass strikes, presses or bounces on a body",
      "A mass meets a body of up to 64 modes through a contact that stiffens and loses as real "
      "ones do, coupled both ways: heavy masses stay longer, light ones bounce back, and pressing "
      "changes the tone. No setting and no sample rate can add energy.",
      "physical model impact contact modal synthesis percussion",
      contact_impact::kInlets,
      contact_impact::kOutlets,
      contact_impact::kParameters,
      contact_impact::kMessages,
      contact::kBodyArguments,
      "contact_friction~, modal_impact~",
      "the model: contact.md"};
  static constexpr bool multichannel = true;

  ContactImpact() {
    for (std::size_t i = 0; i < value_.size(); ++i)
      value_[i] = contact_impact::kParameters[i].initial;
    body_.set_gain(value_[contact_impact::kGain]);
    update_law();
  }

  void prepare(double sample_rate, std::size_t) { body_.prepare(sample_rate); }
  void set(std::size_t parameter, double value) noexcept {
    if (parameter == contact_impact::kSeed)
      random_.seed(static_cast<std::uint64_t>(value)); // also where the value is the same
    if (value_[parameter] == value)
      return;
    value_[parameter] = value;
    if (parameter == contact_impact::kBody)
      body_.set_mass(value);
    if (parameter == contact_impact::kGain)
      body_.set_gain(value);
    if (parameter <= contact_impact::kDissipation)
      update_law();
  }
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }

  void message(std::size_t index, std::span<const Atom> words, Host& host) {
    using namespace contact_impact;
    switch (index) {
    case kModes:
      return body_.parse_modes(words, host);
    case kPickup:
      return body_.parse_pickup(words, host);
    case kStrike:
      if (words[0].is_word || !(std::abs(words[0].number) <= 1000))
        return host.error(refusal("strike", words, "a velocity in -1000..1000 m/s"));
      last_ = {0, words[0].number};
      break;
    case kDrop:
      if (words[0].is_word || !(words[0].number >= 0 && words[0].number <= 1e5))
        return host.error(refusal("drop", words, "a height in 0..100000 mm"));
      if (value_[kGravity] <= 0)
        return host.error("drop: nothing falls while gravity is 0");
      last_ = {1e-3 * words[0].number, 0};
      break;
    case kReset:
      random_.seed(static_cast<std::uint64_t>(value_[kSeed]));
      return body_.reset();
    default:
      break;
    }
    const double variation = value_[kVariation];
    const double factor =
        variation > 0 ? contact::StrikeScatter::draw(variation, 0, random_).speed_factor : 1;
    // Who falls from h arrives with sqrt(2 g h).
    body_.launch_mass(0, factor * factor * last_.gap_m, factor * last_.velocity_m_per_s);
  }

  template <class S> void process(const Block<S>& block) noexcept {
    const auto force = block.in(0);
    const auto sound = block.out(0), contact = block.out(1);
    const double weight = value_[contact_impact::kMass] * value_[contact_impact::kGravity];
    contact::ChunkBuffer drive, output, contact_force;
    for (std::size_t from = 0; from < block.frames; from += drive.size()) {
      const std::size_t count = std::min(drive.size(), block.frames - from);
      for (std::size_t n = 0; n < count; ++n)
        drive[n] = static_cast<double>(force[from + n]) + weight;
      body_.run_mass(0, std::span(drive).first(count), output, contact_force);
      body_.make_sound(std::span<const double>(output).first(count), sound.subspan(from, count));
      for (std::size_t n = 0; n < count; ++n)
        contact[from + n] = static_cast<S>(contact_force[n]);
    }
  }
  /// Reports the last contact of a block; a chattering mass may have several.
  void report(Host& host) {
    const contact::Exciter& e = body_.exciter(0);
    if (e.impact_count == reported_)
      return;
    reported_ = e.impact_count;
    if (reported_ > 0)
      host.send(kImpactOutlet, {1e3 * e.last.duration_s, e.last.impulse_ns});
  }
  void dump(Host& host) {
    body_.post_info(host);
    host.info({"impacts", static_cast<double>(body_.exciter(0).impact_count)});
  }

private:
  static constexpr std::size_t kImpactOutlet = 2;
  void update_law() noexcept {
    using namespace contact_impact;
    body_.set_impact(0, {value_[kStiffness], value_[kExponent], value_[kDissipation]},
                     value_[kMass]);
  }

  struct Launch {
    double gap_m, velocity_m_per_s;
  };
  contact::SoundingBody body_;
  std::array<double, contact_impact::kParameters.size()> value_{};
  Launch last_{0, 1}; // as it was meant
  Random random_;     // of variation
  std::size_t reported_ = 0;
};

} // namespace tactus
