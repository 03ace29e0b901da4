#pragma once

#include "core/contact/friction_rows.hpp"
#include "core/rows.hpp"
#include "externals/contact_impact~/sounding_body.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus {
/// [contact_friction~]: a surface rubs a body of several modes (core/contact/excited_body.hpp).
class ContactFriction {
public:
  static const Declaration declaration;
  static constexpr bool multichannel = true;

  ContactFriction() {
    body_.set_mass(kBodyMass);
    body_.set_gain(kGain);
    update_law();
    set_seed(seed_);
  }

  void prepare(double sample_rate, std::size_t) { body_.prepare(sample_rate); }
  template <class S> void process(const Block<S>& block) noexcept {
    const auto velocity = block.in(0), normal = block.in(1);
    const auto sound = block.out(0), friction = block.out(1);
    contact::ChunkBuffer speed, pressure, output, friction_force;
    for (std::size_t from = 0; from < block.frames; from += speed.size()) {
      const std::size_t count = std::min(speed.size(), block.frames - from);
      for (std::size_t n = 0; n < count; ++n) {
        speed[n] = static_cast<double>(velocity[from + n]);
        pressure[n] = static_cast<double>(normal[from + n]);
      }
      body_.run_rub(0, std::span(speed).first(count), pressure, output, friction_force);
      body_.make_sound(std::span<const double>(output).first(count), sound.subspan(from, count));
      for (std::size_t n = 0; n < count; ++n)
        friction[from + n] = static_cast<S>(friction_force[n]);
    }
  }
  void dump(Host& host) { body_.post_info(host); }

private:
  struct Rows;
  static constexpr double kGain = 3, kBodyMass = 0.05; ///< initial values in s/m and kg

  [[nodiscard]] const contact::FrictionLaw& law() const noexcept { return law_; }
  void take_law(const contact::FrictionLaw& law) noexcept {
    law_ = law;
    update_law();
  }
  void update_law() noexcept { body_.set_friction(0, law_); }
  void update_steps() noexcept { body_.set_min_steps(static_cast<unsigned>(steps_)); }
  [[nodiscard]] unsigned seed() const noexcept { return seed_; }
  void set_seed(unsigned value) noexcept {
    seed_ = value;
    body_.seed(0, value);
  }
  void reset() {
    body_.reset();
    set_seed(seed_);
  }

  contact::SoundingBody body_;
  contact::FrictionLaw law_;
  unsigned seed_ = 1;
  double steps_ = 1; ///< as given; the fraction is ignored
};

struct ContactFriction::Rows {
  using Self = ContactFriction;
  using Body = contact::SoundingBody;
  static constexpr auto parameters =
      joined(rows_of_field<&Self::law, &Self::take_law, contact::kFrictionRows>(),
             std::array{
                 property<&Self::seed, &Self::set_seed>.seed<"seed of the roughness">(),
                 property<&Body::mass, &Body::set_mass, &Self::body_>.row(
                     "body", "kg", kBodyMass, 1e-4, 1e5, "modal mass of a mode with gain 1"),
                 member<&Self::steps_>.then<&Self::update_steps>().row(
                     "steps", "", 1, 1, 64,
                     "minimum number of integration steps a sample; light bodies get up to 8 "
                     "automatically"),
                 property<&Body::gain, &Body::set_gain, &Self::body_>.row(
                     "gain", "s/m", kGain, 0, 1e5, "output at a body velocity of 1 m/s"),
             });
  static constexpr std::array messages{
      action<&Self::body_, &Body::parse_modes>(contact::kModesMessage),
      action<&Self::body_, &Body::parse_pickup>(contact::kPickupMessage),
      realtime(
          action<&Self::reset>("reset", "", 0, 0, "stop all motion: silence, bristles straight")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "velocity", "m/s", "velocity of the rubbing surface"},
      Port{Port::Kind::kSignal, "normal", "N",
           "normal force of the rubbing surface; 0: no contact"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "velocity of the body times `gain`, within +-1"},
      Port{Port::Kind::kSignal, "friction", "N", "friction force along the body's surface"},
  };
};

inline constexpr Declaration ContactFriction::declaration{
    "contact_friction~",
    "a surface rubs a body: squeaks, creaks, bows and brakes",
    "A moving surface rubs a body of up to 64 modes. Elasto-plastic bristles between the two bend "
    "and slip, so that each acts on the other. Pressure and speed are signals. No setting and no "
    "sample rate can add energy.",
    "physical model friction stick slip squeak creak bow modal synthesis",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    contact::kBodyArguments,
    "contact_impact~, modal_impact~",
    "how to use it: contact.md, the model: theory/contact.md"};

} // namespace tactus
