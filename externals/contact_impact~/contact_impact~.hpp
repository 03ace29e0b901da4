#pragma once

#include "core/contact/strike_scatter.hpp"
#include "core/dsp/random.hpp"
#include "core/refusal.hpp"
#include "core/rows.hpp"
#include "externals/contact_impact~/sounding_body.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus {

/// [contact_impact~]: a mass strikes a body of several modes (core/contact/excited_body.hpp).
class ContactImpact {
public:
  static const Declaration declaration;
  static constexpr bool multichannel = true;

  ContactImpact() {
    body_.set_gain(kGain);
    body_.set_mass(kBodyMass);
    update_law();
  }

  void prepare(double sample_rate, std::size_t) { body_.prepare(sample_rate); }
  template <class S> void process(const Block<S>& block) noexcept {
    const auto force = block.in(0);
    const auto sound = block.out(0), contact = block.out(1);
    const double weight = mass_kg_ * gravity_m_per_s2_;
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
  struct Rows;
  struct Launch {
    double gap_m, velocity_m_per_s;
  };
  static constexpr std::size_t kImpactOutlet = 2;
  static constexpr double kGain = 5, kBodyMass = 0.3; ///< initial values in s/m and kg

  void update_law() noexcept { body_.set_impact(0, law_, mass_kg_); }
  [[nodiscard]] unsigned seed() const noexcept { return seed_; }
  void set_seed(unsigned value) noexcept {
    seed_ = value;
    random_.seed(value);
  }
  void strike(std::span<const Atom> words, Host& host) {
    if (words[0].is_word || !(std::abs(words[0].number) <= 1000))
      return host.error(refusal("strike", words, "a velocity in -1000..1000 m/s"));
    last_ = {0, words[0].number};
    launch();
  }
  void drop(std::span<const Atom> words, Host& host) {
    if (words[0].is_word || !(words[0].number >= 0 && words[0].number <= 1e5))
      return host.error(refusal("drop", words, "a height in 0..100000 mm"));
    if (gravity_m_per_s2_ <= 0)
      return host.error("drop: nothing falls while gravity is 0");
    last_ = {1e-3 * words[0].number, 0};
    launch();
  }
  /// Performs the last strike or drop, with random scatter.
  void launch() {
    const double factor =
        variation_ > 0 ? contact::StrikeScatter::draw(variation_, 0, random_).speed_factor : 1;
    // A mass that falls from height h arrives with sqrt(2 g h).
    body_.launch_mass(0, factor * factor * last_.gap_m, factor * last_.velocity_m_per_s);
  }
  void reset() {
    set_seed(seed_);
    body_.reset();
  }

  contact::SoundingBody body_;
  contact::ImpactLaw law_;
  double mass_kg_ = 0.02, gravity_m_per_s2_ = 0, variation_ = 0;
  unsigned seed_ = 1;
  Launch last_{0, 1}; // values before variation
  Random random_;     // for variation
  std::size_t reported_ = 0;
};

struct ContactImpact::Rows {
  using Self = ContactImpact;
  using Law = contact::ImpactLaw;
  using Body = contact::SoundingBody;
  static constexpr std::array parameters{
      member<&Self::mass_kg_>.then<&Self::update_law>().row("mass", "kg", 0.02, 1e-5, 1000,
                                                            "mass of the striker"),
      member<&Self::law_, &Law::stiffness>.then<&Self::update_law>().row(
          "stiffness", "N/m^exponent", 1, 1e16, "contact stiffness k"),
      member<&Self::law_, &Law::exponent>.then<&Self::update_law>().row(
          "exponent", "", 1, 4,
          "exponent of the contact law: 1: spring, 1.5: round bodies, above 1.5: felt"),
      member<&Self::law_, &Law::dissipation_s_per_m>.then<&Self::update_law>().row(
          "dissipation", "s/m", 0, 1000,
          "contact dissipation mu; the energy loss grows with mu times the impact speed"),
      member<&Self::gravity_m_per_s2_>.row("gravity", "m/s^2", 0, 0, 1000,
                                           "acceleration of the mass towards the body"),
      property<&Body::mass, &Body::set_mass, &Self::body_>.row("body", "kg", kBodyMass, 1e-4, 1e5,
                                                               "modal mass of a mode with gain 1"),
      property<&Body::gain, &Body::set_gain, &Self::body_>.row(
          "gain", "s/m", kGain, 0, 1e5, "output at a body velocity of 1 m/s"),
      member<&Self::variation_>.row("variation", "", 0, 0, 1,
                                    "scatter of the strikes' speed: 0: none, 1: as by a hand"),
      property<&Self::seed, &Self::set_seed>.seed<"seed of the variation">(),
  };
  static constexpr std::array messages{
      action<&Self::body_, &Body::parse_modes>(contact::kModesMessage),
      action<&Self::body_, &Body::parse_pickup>(contact::kPickupMessage),
      realtime(action<&Self::strike>(
          "strike", "v", 1, 1,
          "strike: the mass hits the body at v m/s; 0: lay the mass on the body")),
      realtime(action<&Self::launch>("bang", "", 0, 0, "repeat the last strike or drop")),
      realtime(action<&Self::drop>("drop", "h", 1, 1,
                                   "drop the mass from h mm; needs `gravity` above 0")),
      realtime(action<&Self::reset>("reset", "", 0, 0,
                                    "stop all motion and sound, and put the mass 1 m away")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "force", "N", "force on the mass, into the body"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "velocity of the body times `gain`, within +-1"},
      Port{Port::Kind::kSignal, "contact", "N", "force between mass and body"},
      Port{Port::Kind::kControl, "impact", "", "duration in ms and impulse in N s of each contact"},
  };
};

inline constexpr Declaration ContactImpact::declaration{
    "contact_impact~",
    "a mass strikes, presses or bounces on a body",
    "A mass strikes a body of up to 64 modes through a nonlinear contact with losses, coupled in "
    "both directions: heavy masses stay longer, light masses bounce back, and pressing changes the "
    "tone. No setting and no sample rate can add energy.",
    "physical model impact contact modal synthesis percussion",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    contact::kBodyArguments,
    "contact_friction~, modal_impact~",
    "how to use it: contact.md, the model: theory/contact.md"};

} // namespace tactus
