#pragma once

#include "core/object.hpp"
#include "externals/contact_impact~/sounding_body.hpp"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus {
namespace contact_friction {

inline constexpr contact::FrictionLaw kLaw{};

enum ParameterIndex : std::size_t {
  kStatic,
  kDynamic,
  kStribeck,
  kBreakaway,
  kStiffness,
  kDamping,
  kViscosity,
  kRoughness,
  kSeed,
  kBody,
  kSteps,
  kGain,
};
inline constexpr std::array kParameters{
    Parameter{"static", "", kLaw.static_coefficient, 0.001, 10,
              "friction coefficient at rest; below dynamic it counts as that"},
    Parameter{"dynamic", "", kLaw.dynamic_coefficient, 0.001, 10,
              "friction coefficient of fast sliding"},
    Parameter{"stribeck", "m/s", kLaw.stribeck_m_per_s, 1e-4, 10,
              "how fast it slides when it has let go"},
    Parameter{"breakaway", "", kLaw.breakaway, 0.01, 0.99,
              "share of the sliding force up to which it only bends"},
    Parameter{"stiffness", "N/m", kLaw.stiffness_n_per_m, 10, 1e9, "sigma0 of the bristles"},
    Parameter{"damping", "N s/m", kLaw.damping_ns_per_m, 0, 1e6, "sigma1 of the bristles"},
    Parameter{"viscosity", "N s/m", kLaw.viscosity_ns_per_m, 0, 1e4, "sigma2, as of a grease"},
    Parameter{"roughness", "", kLaw.roughness, 0, 100,
              "random force, times sqrt(normal force times speed)"},
    seed_parameter<"seed of the roughness">(),
    Parameter{"body", "kg", 0.05, 1e-4, 1e5, "modal mass of every mode of gain 1"},
    Parameter{"steps", "", 1, 1, 64, "of a sample at least; a light body takes up to 8 by itself"},
    Parameter{"gain", "s/m", 3, 0, 1e5, "of the sound: times the body's velocity"},
};

enum MessageIndex : std::size_t { kModes, kPickup, kReset };
inline constexpr std::array kMessages{
    contact::kModesMessage,
    contact::kPickupMessage,
    realtime(Message{"reset", "", 0, 0, "silence, bristles straight"}),
};

inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "velocity", "m/s", "of the surface that rubs"},
    Port{Port::Kind::kSignal, "normal", "N", "how hard it presses; 0: it does not touch"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "sound", "", "velocity of the body times gain, within +-1"},
    Port{Port::Kind::kSignal, "friction", "N", "force along the surface, on the body"},
};

} // namespace contact_friction

/// [contact_friction~]: a surface rubs a body of some modes (core/contact/excited_body.hpp).
class ContactFriction {
public:
  static constexpr Declaration declaration{
      "contact_friction~",
      "a surface rubs a body: squeaks, creaks, bows and brakes",
      "A moving surface presses on a body of up to 64 modes and drags it by elasto-plastic "
      "bristles that bend, let go and slip, coupled both ways. Pressure and speed are signals. No "
      "setting and no sample rate can add energy.",
      "physical model friction stick slip squeak creak bow modal synthesis",
      contact_friction::kInlets,
      contact_friction::kOutlets,
      contact_friction::kParameters,
      contact_friction::kMessages,
      contact::kBodyArguments,
      "contact_impact~, modal_impact~",
      "the model: contact.md"};
  static constexpr bool multichannel = true;

  ContactFriction() {
    for (std::size_t i = 0; i < value_.size(); ++i)
      value_[i] = contact_friction::kParameters[i].initial;
    body_.set_mass(value_[contact_friction::kBody]);
    body_.set_gain(value_[contact_friction::kGain]);
    update_law();
    seed();
  }

  void prepare(double sample_rate, std::size_t) { body_.prepare(sample_rate); }
  void set(std::size_t parameter, double value) noexcept {
    using namespace contact_friction;
    if (value_[parameter] == value)
      return;
    value_[parameter] = value;
    if (parameter == kBody)
      body_.set_mass(value);
    else if (parameter == kGain)
      body_.set_gain(value);
    else if (parameter == kSteps)
      body_.set_min_steps(static_cast<unsigned>(value));
    else if (parameter == kSeed)
      seed();
    else if (parameter <= kRoughness)
      update_law();
  }
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }

  void message(std::size_t index, std::span<const Atom> words, Host& host) {
    using namespace contact_friction;
    if (index == kModes)
      return body_.parse_modes(words, host);
    if (index == kPickup)
      return body_.parse_pickup(words, host);
    body_.reset();
    seed();
  }

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
  void update_law() noexcept {
    using namespace contact_friction;
    body_.set_friction(0, {value_[kStatic], value_[kDynamic], value_[kStribeck], value_[kBreakaway],
                           value_[kStiffness], value_[kDamping], value_[kViscosity],
                           value_[kRoughness]});
  }
  void seed() noexcept {
    body_.seed(0, static_cast<std::uint64_t>(value_[contact_friction::kSeed]));
  }

  contact::SoundingBody body_;
  std::array<double, contact_friction::kParameters.size()> value_{};
};

} // namespace tactus
