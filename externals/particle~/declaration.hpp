#pragma once

#include "core/declaration.hpp"
#include "core/particle/presets.hpp"

#include <array>
#include <cstddef>
#include <string_view>

/// Declaration of [particle~]: inlets, outlets, parameters and messages. The parameters of clouds
/// have the names, units and ranges of a recipe's keys (core/footstep/recipe_keys.cpp).
namespace tactus::particle {

inline constexpr std::array<std::string_view, 3> kKinds{"grains", "bubbles", "rustle"};

enum ParameterIndex : std::size_t {
  kKind,
  kCount,
  kDecay,
  kAttack,
  kExponent,
  kLargest,
  kFrequency,
  kSpread,
  kLowerBySize,
  kQuality,
  kLength,
  kRise,
  kLevel,
  kDirect,
  kGain,
  kSeed,
};
inline constexpr std::array kParameters{
    Parameter{"kind", "", 0, 0, 2, "noisy grains, bubbles, or a rustle of countless grains",
              kKinds},
    Parameter{"count", "", kMaraca.count, 0, 50000, "collisions for each unit of energy"},
    Parameter{"decay", "s", kMaraca.decay_s, 1e-4, 60, "in which the energy falls to 1/e"},
    Parameter{"attack", "s", kMaraca.attack_s, 1e-4, 5, "in which the energy of a shake arrives"},
    Parameter{"exponent", "", kMaraca.exponent, 0.05, 20,
              "of the collisions' energies: density ~ e^-(exponent + 1)"},
    Parameter{"largest", "", kMaraca.largest, 1.001, 1e6,
              "collision over the smallest, in energy; 1.001: all alike"},
    Parameter{"frequency", "Hz", kMaraca.frequency_hz, 20, 20000,
              "median of the grains', of the smallest ones' with lower_by_size"},
    Parameter{"spread", "", kMaraca.spread, 0, 3, "standard deviation of its natural logarithm"},
    Parameter{"lower_by_size", "", kMaraca.lower_by_size, 0, 2,
              "frequency ~ collision energy^-this: big grains sound lower"},
    Parameter{"quality", "", kMaraca.quality, 0.1, 200, "Q of a grain's band-pass"},
    Parameter{"length", "s", kMaraca.length_s, 1e-5, 1,
              "median time in which a grain's amplitude falls to 1/e"},
    Parameter{"rise", "", kMaraca.rise, 0, 1, "of a bubble's pitch while it decays"},
    Parameter{"level", "", kMaraca.level, 0, 1e4, "strength of the sound, of new collisions"},
    Parameter{"direct", "", 1, 0, 1, "share of the grains that is heard beside the modes"},
    Parameter{"gain", "", 1, 0, 1000, "of the sound, smoothed"},
    seed_parameter<"seed of everything that is random; setting it restarts the random sequence">(),
};

enum MessageIndex : std::size_t { kPresetMessage, kModes, kShake, kBang, kReset };
inline constexpr std::array kMessages{
    Message{"preset", "maraca|sekere|cabasa|tambourine|gravel|ice|coins|rain|sand|leaves|bubbles",
            1, 1, "particles and modes at once; gain and seed stay"},
    Message{
        "modes", "[f1 t1 g1 f2 t2 g2 ...]", 0, 3 * RingingBody::kMaxModes,
        "what the particles strike, or coins: of each mode frequency in Hz, time in s in which it "
        "falls by 60 dB, and gain, the root of its ring's energy over a grain's; none: nothing"},
    realtime(
        Message{"shake", "e", 1, 1, "energy e arrives, 0 to 1000; 1: an ordinary shake or step"}),
    realtime(Message{"bang", "", 0, 0, "the last shake again; 1 at first"}),
    realtime(Message{"reset", "", 0, 0, "silence within 5 ms, no energy"}),
};

inline constexpr std::array kArguments{CreationArgument{"preset"}};
inline constexpr std::array kInlets{
    Port{Port::Kind::kSignal, "power", "1/s",
         "energy each second; the energy tends to power * decay"},
};
inline constexpr std::array kOutlets{
    Port{Port::Kind::kSignal, "sound", "", "within +-1"},
    Port{Port::Kind::kSignal, "collisions", "",
         "impulses: root of each one's energy (1: a mean one at energy 1)"},
    Port{Port::Kind::kSignal, "energy", "", "of the system, in ordinary shakes"},
};

} // namespace tactus::particle
