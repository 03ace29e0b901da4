#pragma once

#include "core/declaration_text.hpp"
#include "core/dsp/soft_clip.hpp"
#include "core/object.hpp"
#include "core/particle/particle_system.hpp"
#include "core/particle/presets.hpp"
#include "core/refusal.hpp"
#include "externals/particle~/declaration.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace tactus {

/// [particle~]: particles that collide while they are shaken, rolled or stepped on
/// (core/particle/particle_system.hpp, docs/particle.md).
class ParticleObject {
public:
  static constexpr Declaration declaration{
      "particle~",
      "particles that are shaken, rolled or stepped on",
      "Energy comes in as a signal of power or as shakes, and dies down. While there is some, "
      "grains "
      "collide or bubbles rise at random: a Poisson process, so that rates and levels are the same "
      "at any sample rate. Each has a frequency, a size and a decay of its own, and strikes the "
      "modes of what holds it. Collisions come out as impulses, too, for any other body.",
      "physical model PhISEM particles shaker granular collisions rain gravel bubbles Poisson",
      particle::kInlets,
      particle::kOutlets,
      particle::kParameters,
      particle::kMessages,
      particle::kArguments,
      "footstep~, modal_impact~",
      "the model: particle.md",
      "particles/piece.wav: maraca, cabasa, tambourine and coins over rain and bubbles"};

  ParticleObject() {
    for (std::size_t i = 0; i < value_.size(); ++i)
      value_[i] = particle::kParameters[i].initial;
    system_.seed(static_cast<std::uint64_t>(value_[particle::kSeed]));
    update();
  }

  void prepare(double sample_rate, std::size_t) { system_.prepare(sample_rate); }
  void set(std::size_t parameter, double value) noexcept {
    value_[parameter] = value;
    if (parameter == particle::kSeed)
      system_.seed(static_cast<std::uint64_t>(value));
    else
      update();
  }
  [[nodiscard]] double get(std::size_t parameter) const noexcept { return value_[parameter]; }

  void message(std::size_t index, std::span<const Atom> words, Host& host) {
    switch (index) {
    case particle::kPresetMessage:
      return take_preset(words[0], host);
    case particle::kModes:
      return take_modes(words, host);
    case particle::kShake:
      if (words[0].is_word || !(words[0].number >= 0 && words[0].number <= 1000))
        return host.error(refusal("shake", words, "an energy in 0..1000"));
      last_shake_ = words[0].number;
      break;
    case particle::kReset:
      return system_.reset();
    default:
      break;
    }
    system_.shake(last_shake_);
  }

  template <class S> void process(const Block<S>& block) noexcept {
    const auto power = block.in(0);
    const auto sound = block.out(0), collisions = block.out(1), energy = block.out(2);
    for (std::size_t n = 0; n < block.frames; ++n) {
      const auto sample = system_.next(static_cast<double>(power[n]));
      sound[n] = static_cast<S>(soft_clip(sample.sound));
      collisions[n] = static_cast<S>(sample.collisions);
      energy[n] = static_cast<S>(sample.energy);
    }
  }

  void dump_first(Host& host) { host.info({"preset", preset_}); }
  void dump(Host& host) {
    std::vector<Atom> modes{"modes"};
    for (const particle::RingingMode& m : system_.modes())
      modes.insert(modes.end(), {m.frequency_hz, m.t60_s, m.gain});
    host.info(modes);
    host.info({"energy", system_.energy()});
    host.info({"collisions", static_cast<double>(system_.collisions())});
  }

private:
  void take_preset(const Atom& name, Host& host) {
    const particle::Preset* preset = name.is_word ? particle::find_preset(name.word) : nullptr;
    if (preset == nullptr)
      return host.error("preset " +
                        (name.is_word ? std::string(name.word) : number_text(name.number)) +
                        ": expected " + std::string(particle::kMessages[0].arguments));
    using namespace particle;
    const CloudSettings& c = preset->cloud;
    for (const auto& [parameter, value] : std::initializer_list<std::pair<ParameterIndex, double>>{
             {kKind, static_cast<double>(c.kind)},
             {kCount, c.count},
             {kDecay, c.decay_s},
             {kAttack, c.attack_s},
             {kExponent, c.exponent},
             {kLargest, c.largest},
             {kFrequency, c.frequency_hz},
             {kSpread, c.spread},
             {kLowerBySize, c.lower_by_size},
             {kQuality, c.quality},
             {kLength, c.length_s},
             {kRise, c.rise},
             {kLevel, c.level},
             {kDirect, preset->direct}})
      value_[parameter] = value;
    preset_ = preset->name;
    modes_.assign(preset->body().begin(), preset->body().end());
    update();
  }

  void take_modes(std::span<const Atom> words, Host& host) {
    std::vector<particle::RingingMode> modes;
    if (const Sentence error = modes_refusal(words, {20, 20000, 0.001, 60, 0, 100}); !error.empty())
      return host.error(error);
    for (std::size_t i = 0; i < words.size(); i += 3)
      modes.push_back({words[i].number, words[i + 1].number, words[i + 2].number});
    modes_ = std::move(modes);
    update();
  }

  void update() noexcept {
    using namespace particle;
    system_.set({static_cast<CloudSettings::Kind>(value_[kKind]), value_[kCount], value_[kAttack],
                 value_[kDecay], value_[kExponent], value_[kLargest], value_[kFrequency],
                 value_[kSpread], value_[kLowerBySize], value_[kQuality], value_[kLength],
                 value_[kRise], value_[kLevel]});
    system_.set_body(modes_, value_[kDirect]);
    system_.set_gain(value_[kGain]);
  }

  particle::ParticleSystem system_;
  std::array<double, particle::kParameters.size()> value_{};
  std::vector<particle::RingingMode> modes_;
  std::string_view preset_ = "maraca"; // the last one chosen
  double last_shake_ = 1;
};

} // namespace tactus
