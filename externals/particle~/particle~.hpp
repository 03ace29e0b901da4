#pragma once

#include "core/declaration_text.hpp"
#include "core/dsp/soft_clip.hpp"
#include "core/particle/cloud_rows.hpp"
#include "core/particle/particle_system.hpp"
#include "core/particle/presets.hpp"
#include "core/refusal.hpp"
#include "core/rows.hpp"

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
  static const Declaration declaration;

  ParticleObject() {
    set_seed(seed_);
    update();
  }

  void prepare(double sample_rate, std::size_t) { system_.prepare(sample_rate); }
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
  struct Rows;

  [[nodiscard]] const particle::CloudSettings& cloud() const noexcept { return cloud_; }
  void take_cloud(const particle::CloudSettings& changed) noexcept {
    cloud_ = changed;
    update();
  }
  [[nodiscard]] unsigned seed() const noexcept { return seed_; }
  void set_seed(unsigned value) noexcept {
    seed_ = value;
    system_.seed(value);
  }
  void shake(std::span<const Atom> words, Host& host) {
    if (words[0].is_word || !(words[0].number >= 0 && words[0].number <= 1000))
      return host.error(refusal("shake", words, "an energy in 0..1000"));
    last_shake_ = words[0].number;
    shake_again();
  }
  void shake_again() noexcept { system_.shake(last_shake_); }
  void take_preset(const Atom& name, Host& host) {
    const particle::Preset* preset = name.is_word ? particle::find_preset(name.word) : nullptr;
    if (preset == nullptr)
      return host.error("preset " +
                        (name.is_word ? std::string(name.word) : number_text(name.number)) +
                        ": expected " + kPresets);
    cloud_ = preset->cloud;
    direct_ = preset->direct;
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
    system_.set(cloud_);
    system_.set_body(modes_, direct_);
    system_.set_gain(gain_);
  }

  static constexpr const char* kPresets =
      "maraca|sekere|cabasa|tambourine|gravel|ice|coins|rain|sand|leaves|bubbles";
  particle::ParticleSystem system_;
  particle::CloudSettings cloud_ = particle::kMaraca;
  double direct_ = 1, gain_ = 1;
  unsigned seed_ = 1;
  std::vector<particle::RingingMode> modes_;
  std::string_view preset_ = "maraca"; // the last preset chosen
  double last_shake_ = 1;
};

struct ParticleObject::Rows {
  using Self = ParticleObject;
  static constexpr auto kCloud = particle::cloud_rows(particle::kMaraca);
  static constexpr auto parameters = joined(
      rows_of_field<&Self::cloud, &Self::take_cloud, kCloud>(),
      std::array{
          member<&Self::direct_>.then<&Self::update>().row(
              "direct", "", 1, 0, 1, "gain of the particles' direct sound, added to the modes"),
          member<&Self::gain_>.then<&Self::update>().row("gain", "", 1, 0, 1000,
                                                         "gain of the sound, smoothed"),
          property<&Self::seed, &Self::set_seed>.seed<"seed of all random numbers; setting it restarts the sequence">(),
      });
  static constexpr std::array messages{
      action<&Self::take_preset>("preset", kPresets, 1, 1,
                                 "preset of particles and modes; `gain` and `seed` are kept"),
      action<&Self::take_modes>(
          "modes", "[f1 t1 g1 f2 t2 g2 ...]", 0, 3 * particle::RingingBody::kMaxModes,
          "modes of the body that the particles strike: frequency in Hz, decay time T60 in s, and "
          "gain, the root of (ringing energy / grain energy); without numbers: none"),
      realtime(action<&Self::shake>("shake", "e", 1, 1,
                                    "add energy e, 0 to 1000; 1: an ordinary shake or step")),
      realtime(action<&Self::shake_again>("bang", "", 0, 0, "repeat the last shake; initially 1")),
      realtime(action<&Self::system_, &particle::ParticleSystem::reset>(
          "reset", "", 0, 0, "stop: silence within 5 ms, no energy")),
  };
  static constexpr std::array inlets{
      Port{Port::Kind::kSignal, "power", "1/s",
           "energy per second; stored energy tends to power * decay"},
  };
  static constexpr std::array outlets{
      Port{Port::Kind::kSignal, "sound", "", "sound, within +-1"},
      Port{Port::Kind::kSignal, "collisions", "",
           "impulses: root of each collision's energy (mean: 1 at energy 1)"},
      Port{Port::Kind::kSignal, "energy", "", "energy, in ordinary shakes"},
  };

  static constexpr std::array arguments{CreationArgument{"preset"}};
};

inline constexpr Declaration ParticleObject::declaration{
    "particle~",
    "particles that one shakes, rolls or steps on",
    "A power signal or shakes supply energy, which decays. While energy remains, grains collide or "
    "bubbles rise at random, as a Poisson process whose rates and levels do not depend on the "
    "sample rate. Each grain or bubble has its own frequency, size and decay, and strikes the "
    "modes of its container. An outlet gives the collisions as impulses for other bodies.",
    "physical model PhISEM particles shaker granular collisions rain gravel bubbles Poisson",
    Rows::inlets,
    Rows::outlets,
    Rows::parameters,
    Rows::messages,
    Rows::arguments,
    "footstep~, modal_impact~",
    "how to use it: particle.md, the model: theory/particle.md",
    "particles/piece.wav: maraca, cabasa, tambourine and coins over rain and bubbles"};

} // namespace tactus
