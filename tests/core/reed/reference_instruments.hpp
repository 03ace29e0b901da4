#pragma once

#include "core/reed/instrument/parameters.hpp"

#include <numbers>

/// The instruments whose thresholds, growth rates and playing states are known from theory. Kept
/// apart from the presets, which may be voiced anew.
namespace tactus::reed::reference {

inline Parameters clarinet(double length = 0.48) {
  Parameters p;
  p.length = length;
  return p;
}

inline Parameters saxophone() {
  Parameters p;
  p.rest_angle = -0.05;
  p.mass = 8e-6;
  p.reed_frequency = 1500;
  p.quality = 3;
  p.width = 14e-3;
  p.mouth_length = p.bore_length = 7e-3;
  p.shape = BoreShape::kCone;
  p.length = 0.5;
  p.input_radius = 6.2e-3;
  p.end_radius = 25e-3;
  p.apex_distance = 0.2;
  p.cup_volume = std::numbers::pi * p.input_radius * p.input_radius * p.apex_distance / 3;
  return p;
}

inline Parameters oboe() {
  Parameters p;
  p.arm_length = 0.008;
  p.rest_angle = -0.03;
  p.mass = 3e-6;
  p.reed_frequency = 2000;
  p.quality = 2;
  p.width = 7e-3;
  p.mouth_length = p.bore_length = 4e-3;
  p.channel_length = 2e-3;
  p.shape = BoreShape::kCone;
  p.length = 0.4;
  p.input_radius = 3e-3;
  p.end_radius = 25e-3;
  p.apex_distance = 0.1;
  p.cup_volume = std::numbers::pi * p.input_radius * p.input_radius * p.apex_distance / 3;
  return p;
}

inline Parameters trumpet(double lip_frequency = 330) {
  Parameters p;
  p.type = ValveType::kOpen;
  p.rest_angle = 0.01;
  p.mass = 8e-5;
  p.reed_frequency = lip_frequency;
  p.quality = 4;
  p.width = 8e-3;
  p.mouth_length = p.bore_length = 5e-3;
  p.displacement_limit = 2e-3;
  p.shape = BoreShape::kCone;
  p.length = 1.2;
  p.input_radius = 5e-3;
  p.end_radius = 40e-3;
  p.apex_distance = 0.25;
  p.cup_volume = 1.1e-6;
  return p;
}

inline Parameters trombone() {
  Parameters p;
  p.type = ValveType::kOpen;
  p.rest_angle = 0.02;
  p.mass = 2e-4;
  p.reed_frequency = 160;
  p.quality = 4;
  p.width = 12e-3;
  p.mouth_length = p.bore_length = 8e-3;
  p.channel_length = 2e-3;
  p.displacement_limit = 4e-3;
  p.length = 2;
  p.input_radius = 6.9e-3;
  p.end_radius = 60e-3;
  p.cup_volume = 5e-6;
  return p;
}

inline Parameters voice() {
  Parameters p;
  p.type = ValveType::kOpen;
  p.rest_angle = 0.02;
  p.mass = 1e-4;
  p.reed_frequency = 120;
  p.width = 14e-3;
  p.mouth_length = p.bore_length = 1e-3;
  p.flow_length = 3e-3;
  p.channel_length = 3e-3;
  p.displacement_limit = 3e-3;
  p.length = 0.17;
  p.input_radius = p.end_radius = 8e-3;
  return p;
}

inline Parameters syrinx() {
  Parameters p;
  p.type = ValveType::kSwinging;
  p.arm_length = 0.003;
  p.rest_angle = 0.03;
  p.mass = 5e-7;
  p.reed_frequency = 1200;
  p.width = 3e-3;
  p.mouth_length = p.bore_length = 0.5e-3;
  p.flow_length = 1.5e-3;
  p.displacement_limit = 1.5e-3;
  p.length = 0.05;
  p.input_radius = 1.75e-3;
  p.end_radius = 3e-3;
  p.oversampling = 4;
  return p;
}

} // namespace tactus::reed::reference
