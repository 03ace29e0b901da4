#include "core/particle/presets.hpp"

#include <algorithm>

namespace tactus::particle {

namespace {

using Kind = CloudSettings::Kind;

// Cook's numbers (Computer Music Journal 21(3), 1997, and the table of instruments in his Synthesis
// ToolKit) are factors per sample at 22.05 kHz. They convert as follows:
//   K, energy kept by the system:  decay = -1 / (22050 ln K)
//   S, level kept by a grain:      length = -1 / (22050 ln S)
//   N objects:                     count / decay = 22050 N / 1024 collisions per second at E = 1
//   R, pole radius of a resonance: quality = pi f / (-22050 ln R), or T60 = ln 1000 / (-22050 ln R)
// All his collisions have the same energy: largest = 1.001.
constexpr std::array kPresets{
    // N 25, K .999, S .95, 3200 Hz, R .96
    Preset{"maraca", kMaraca},
    // N 64, K .999, S .96, 5500 Hz, R .6
    Preset{"sekere",
           {.count = 62.4,
            .attack_s = 0.005,
            .decay_s = 0.0453,
            .exponent = 1,
            .largest = 1.001,
            .frequency_hz = 5500,
            .spread = 0,
            .quality = 1.53,
            .length_s = 0.00111,
            .level = 0.0155}},
    // N 512, K .997, S .96, 3000 Hz, R .7
    Preset{"cabasa",
           {.count = 166,
            .attack_s = 0.005,
            .decay_s = 0.0151,
            .exponent = 1,
            .largest = 1.001,
            .frequency_hz = 3000,
            .spread = 0,
            .quality = 1.2,
            .length_s = 0.00111,
            .level = 0.0116}},
    // N 32, K .9985, S .95; shell 2300 Hz, R .96, gain .1; jingles 5600 and 8100 Hz, R .99
    Preset{"tambourine",
           {.count = 20.8,
            .attack_s = 0.005,
            .decay_s = 0.0302,
            .exponent = 1,
            .largest = 1.001,
            .frequency_hz = 5600,
            .spread = 0.5,
            .quality = 0.7,
            .length_s = 0.00088,
            .level = 0.0116},
           0.1,
           3,
           {{{2300, 0.00767, 0.1}, {5600, 0.0312, 0.8}, {8100, 0.0312, 1}}}},
    // Stones of 16 mm that meet at 0.5 m/s touch for 60 us (Hertz: 8.3 kHz); time ~ size, energy ~
    // size^3. Cook's little and big rocks have 9000 and 6460 Hz, R .93.
    Preset{"gravel",
           {.count = 60,
            .attack_s = 0.01,
            .decay_s = 0.08,
            .exponent = 1.2,
            .largest = 100,
            .frequency_hz = 9000,
            .spread = 0.3,
            .lower_by_size = 0.3333,
            .quality = 2,
            .length_s = 0.0022,
            .level = 0.0124}},
    // Cubes of 2 cm that knock on a tumbler for 0.14 ms (Hertz: 3.7 kHz); the glass, radius 35 mm,
    // height 100 mm, wall 2.5 mm, at its bending modes n = 2, 3, 4 (French 1983).
    Preset{"ice",
           {.count = 12,
            .attack_s = 0.01,
            .decay_s = 0.15,
            .exponent = 1.5,
            .largest = 20,
            .frequency_hz = 3700,
            .spread = 0.3,
            .quality = 1,
            .length_s = 0.0005,
            .level = 0.0139},
           0.5,
           3,
           {{{1345, 0.2, 0.7}, {3805, 0.15, 0.7}, {7295, 0.1, 0.5}}}},
    // Silver dollars (38.1 mm, 2.4 mm) and halves (30.6 mm, 2.15 mm): modes (2,0), (0,1), (3,0) of
    // free disks (Leissa 1969). T60 of Cook's penny, R .999; a click where rims meet.
    Preset{"coins",
           {.count = 15,
            .attack_s = 0.01,
            .decay_s = 0.1,
            .exponent = 1.5,
            .largest = 30,
            .frequency_hz = 8000,
            .spread = 0.3,
            .quality = 1,
            .length_s = 0.0003,
            .level = 0.0131},
           0.4,
           6,
           {{{4854, 0.31, 0.8},
             {8394, 0.31, 0.5},
             {11300, 0.31, 0.4},
             {6742, 0.31, 0.8},
             {11659, 0.31, 0.4},
             {15695, 0.31, 0.3}}}},
    // Drops of 1 to 4 mm at their terminal velocities, 4 to 9 m/s (Gunn & Kinzer 1949); they spread
    // within 0.25 to 0.45 ms. Sizes of rain of 10 mm/h (Marshall & Palmer 1948), as a power law of
    // energy.
    Preset{"rain",
           {.count = 400,
            .attack_s = 0.05,
            .decay_s = 1,
            .exponent = 0.94,
            .largest = 390,
            .frequency_hz = 4000,
            .spread = 0.4,
            .lower_by_size = 0.1,
            .quality = 0.7,
            .length_s = 0.0005,
            .level = 0.0184}},
    // The band is that of Cook's sandpaper (4500 Hz, R .6); count and sizes are those of
    // footstep~'s sand, which is fitted to recordings.
    Preset{"sand",
           {.count = 600,
            .attack_s = 0.005,
            .decay_s = 0.046,
            .exponent = 1.6,
            .largest = 40,
            .frequency_hz = 4500,
            .spread = 0.6,
            .quality = 1.26,
            .length_s = 0.0005,
            .level = 0.0171}},
    // Crumpling: exponents 0.3 to 0.6 (Houle & Sethna 1996); the other settings are close to those
    // of footstep~'s dry leaves.
    Preset{"leaves",
           {.count = 150,
            .attack_s = 0.02,
            .decay_s = 0.25,
            .exponent = 0.6,
            .largest = 500,
            .frequency_hz = 6150,
            .spread = 0.6,
            .quality = 0.7,
            .length_s = 0.004,
            .level = 0.02}},
    // Radii r from 1 mm (3 kHz) to 8 mm with density ~ r^(-10/3) (Deane & Stokes 2002), energy ~
    // r^3: so the exponent of the energies is 7/9 and frequency ~ energy^(-1/3). Rise: van den Doel
    // 2005.
    Preset{"bubbles",
           {.kind = Kind::kBubbles,
            .count = 60,
            .attack_s = 0.02,
            .decay_s = 0.3,
            .exponent = 0.778,
            .largest = 512,
            .frequency_hz = 3000,
            .spread = 0,
            .lower_by_size = 0.3333,
            .rise = 0.1,
            .level = 0.036}},
};

} // namespace

std::span<const Preset> presets() noexcept { return kPresets; }

const Preset* find_preset(std::string_view name) noexcept {
  const auto* found = std::find_if(kPresets.begin(), kPresets.end(),
                                   [name](const Preset& preset) { return preset.name == name; });
  return found == kPresets.end() ? nullptr : found;
}

} // namespace tactus::particle
