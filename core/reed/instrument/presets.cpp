#include "core/reed/instrument/presets.hpp"

#include <array>
#include <numbers>

namespace tactus::reed {
namespace {

/// Volume of the missing tip of a cone: a mouthpiece of this volume keeps its resonances harmonic.
constexpr double tip_volume(double radius, double apex_distance) {
  return std::numbers::pi * radius * radius * apex_distance / 3;
}

constexpr Parameters clarinet() {
  return {.type = ValveType::kClosed,
          .rest_angle = -0.04,
          .arm_length = 0.01,
          .mass = 3.376e-6,
          .reed_frequency = 2500,
          .quality = 5,
          .width = 13e-3,
          .mouth_length = 6.5e-3,
          .bore_length = 6.5e-3,
          .channel_length = 1e-3,
          .displacement_limit = 5e-3,
          .length = 0.48,
          .input_radius = 7.5e-3,
          .end_radius = 7.5e-3,
          .bell = 1600,
          .bell_quality = 1.4,
          .end = BoreEnd::kClarinet,
          .gain = 0.2,
          .aim = -8,
          .lip_mass = 0.95,
          .lip_opening = 0.86,
          .lip_width = 1.02,
          .lip_quality = 0.9,
          .lip_channel = 2,
          .tongue = 0.06,
          .breath_reference = 2000,
          .breath_opening = 0.36,
          .breath_tension = 0.3,
          .breath_quality = 1.5,
          .lowest_note = 146.8,
          .highest_note = 987.8};
}

constexpr Parameters saxophone() {
  return {.type = ValveType::kClosed,
          .rest_angle = -0.05,
          .arm_length = 0.01,
          .mass = 8e-6,
          .reed_frequency = 1500,
          .quality = 3,
          .width = 14e-3,
          .mouth_length = 7e-3,
          .bore_length = 7e-3,
          .channel_length = 1e-3,
          .displacement_limit = 5e-3,
          .shape = BoreShape::kCone,
          .length = 0.5,
          .input_radius = 6.2e-3,
          .end_radius = 25e-3,
          .apex_distance = 0.2,
          .cup_volume = tip_volume(6.2e-3, 0.2),
          .bell = 3000,
          .bell_quality = 3.4,
          .brassiness = 5,
          .end = BoreEnd::kSaxophone,
          .gain = 0.11,
          .embouchure_slope = -1.4,
          .steepening = 0.02,
          .aim = -20,
          .lip_mass = 5.4,
          .lip_opening = 0.15,
          .lip_width = 1.4,
          .lip_quality = 0.9,
          .lip_cup = 0.5,
          .tongue = 0.15,
          .breath_reference = 2000,
          .breath_opening = 0.65,
          .breath_tension = 0.33,
          .breath_quality = 0.3,
          .lowest_note = 103.8,
          .highest_note = 659.3};
}

constexpr Parameters oboe() {
  return {.type = ValveType::kClosed,
          .rest_angle = -0.03,
          .arm_length = 0.008,
          .mass = 3e-6,
          .reed_frequency = 2000,
          .quality = 2,
          .width = 7e-3,
          .mouth_length = 4e-3,
          .bore_length = 4e-3,
          .channel_length = 2e-3,
          .displacement_limit = 5e-3,
          .shape = BoreShape::kCone,
          .length = 0.4,
          .input_radius = 3e-3,
          .end_radius = 25e-3,
          .apex_distance = 0.1,
          .cup_volume = tip_volume(3e-3, 0.1),
          .bell = 1670,
          .bell_quality = 2.5,
          .brassiness = 2.5,
          .end = BoreEnd::kOboe,
          .gain = 0.12,
          .embouchure_slope = -1.1,
          .steepening = 0.27,
          .lip_mass = 2.5,
          .lip_opening = 0.43,
          .lip_width = 1.6,
          .lip_channel = 0.47,
          .lip_cup = 0.98,
          .tongue = 0.22,
          .breath_reference = 2000,
          .breath_opening = 0.6,
          .breath_tension = 0.25,
          .breath_quality = 0.2,
          .lowest_note = 233.0,
          .highest_note = 1046.5};
}

constexpr Parameters trumpet() {
  return {.type = ValveType::kOpen,
          .rest_angle = 0.01,
          .arm_length = 0.01,
          .mass = 8e-5,
          .reed_frequency = 330,
          .quality = 4,
          .width = 8e-3,
          .mouth_length = 5e-3,
          .bore_length = 5e-3,
          .channel_length = 1e-3,
          .displacement_limit = 2e-3,
          .shape = BoreShape::kCone,
          .length = 1.2,
          .input_radius = 5e-3,
          .end_radius = 40e-3,
          .apex_distance = 0.25,
          .cup_volume = 1.1e-6,
          .bell = 1080,
          .bell_quality = 1.05,
          .brassiness = 5.2,
          .gain = 0.04,
          .embouchure = 0.75,
          .embouchure_slope = -0.07,
          .highest_mode = 1,
          .steepening = 1.13,
          .aim = -90,
          .lip_mass = 0.517,
          .lip_opening = 0.9,
          .lip_width = 0.82,
          .lip_quality = 8.7,
          .lip_limit = 1.75,
          .tongue = 1.1,
          .breath_reference = 3000,
          .breath_opening = 0.5,
          .breath_tension = 0.477,
          .lowest_note = 164.8,
          .highest_note = 740.0};
}

constexpr Parameters trombone() {
  return {.type = ValveType::kOpen,
          .rest_angle = 0.02,
          .arm_length = 0.01,
          .mass = 2e-4,
          .reed_frequency = 160,
          .quality = 4,
          .width = 12e-3,
          .mouth_length = 8e-3,
          .bore_length = 8e-3,
          .channel_length = 2e-3,
          .displacement_limit = 4e-3,
          .length = 2,
          .input_radius = 6.9e-3,
          .end_radius = 60e-3,
          .cup_volume = 5e-6,
          .bell = 795,
          .bell_quality = 3,
          .brassiness = 5.9,
          .gain = 0.035,
          .embouchure = 0.8,
          .embouchure_slope = -0.02,
          .highest_mode = 2,
          .steepening = 4,
          .aim = -135,
          .lip_mass = 0.33,
          .lip_opening = 0.4,
          .lip_width = 0.33,
          .lip_quality = 8,
          .lip_limit = 1.5,
          .played_gain = 2.8,
          .tongue = 0.8,
          .breath_reference = 2000,
          .breath_opening = 0.52,
          .breath_tension = 0.449,
          .lowest_note = 82.4,
          .highest_note = 523.3};
}

constexpr Parameters voice() {
  return {.type = ValveType::kOpen,
          .rest_angle = 0.02,
          .arm_length = 0.01,
          .mass = 1e-4,
          .reed_frequency = 120,
          .quality = 5,
          .width = 14e-3,
          .mouth_length = 1e-3,
          .bore_length = 1e-3,
          .flow_length = 3e-3,
          .channel_length = 3e-3,
          .displacement_limit = 3e-3,
          .length = 0.17,
          .input_radius = 8e-3,
          .end_radius = 8e-3,
          .gain = 1.5,
          .embouchure = 0.95,
          .shortest_tract = 0.08,
          .aim = -85,
          .lip_quality = 1.3,
          .tongue = 0.1,
          .breath_reference = 2000,
          .lowest_note = 82.4,
          .highest_note = 554.4};
}

constexpr Parameters syrinx() {
  return {.type = ValveType::kSwinging,
          .rest_angle = 0.03,
          .arm_length = 0.003,
          .mass = 5e-7,
          .reed_frequency = 1200,
          .quality = 5,
          .width = 3e-3,
          .mouth_length = 0.5e-3,
          .bore_length = 0.5e-3,
          .flow_length = 1.5e-3,
          .channel_length = 1e-3,
          .displacement_limit = 1.5e-3,
          .length = 0.05,
          .input_radius = 1.75e-3,
          .end_radius = 3e-3,
          .gain = 5,
          .embouchure = 1.122,
          .aim = -120,
          .lip_mass = 0.674,
          .lip_width = 0.804,
          .lip_quality = 1.103,
          .tongue = 0.3,
          .breath_reference = 700,
          .lowest_note = 415.3,
          .highest_note = 2489.0};
}

constexpr std::array<Preset, 7> kPresets{{{"clarinet", clarinet()},
                                          {"sax", saxophone()},
                                          {"oboe", oboe()},
                                          {"trumpet", trumpet()},
                                          {"trombone", trombone()},
                                          {"voice", voice()},
                                          {"syrinx", syrinx()}}};

} // namespace

std::span<const Preset> presets() noexcept { return kPresets; }

std::optional<Parameters> find_preset(std::string_view name) noexcept {
  for (const Preset& preset : kPresets)
    if (preset.name == name)
      return preset.parameters;
  return std::nullopt;
}

std::string_view preset_name(std::string_view name) noexcept {
  for (const Preset& preset : kPresets)
    if (preset.name == name)
      return preset.name;
  return {};
}

} // namespace tactus::reed
