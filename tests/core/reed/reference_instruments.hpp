#pragma once

#include "core/reed/instrument/parameters.hpp"

#include <numbers>
#include <vector>

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

/// What linear theory says of them, by an independent implementation of the same equations (numpy,
/// roots polished in extended precision), quoted to five digits.
struct LinearState {
  const char* name;
  Parameters parameters;
  double pressure;                   // in the mouth, Pa
  double frequency_hz, growth_per_s; // of the dominant mode
  double near_hz = 0;                // where that is not the first to start: the one meant
};

inline std::vector<LinearState> thresholds() {
  return {{"clarinet", clarinet(), 1472.3, 171.96, 0},
          {"short clarinet", clarinet(0.3), 1433.7, 272.31, 0},
          {"long clarinet", clarinet(0.8), 1524.1, 103.64, 0},
          {"saxophone, fundamental", saxophone(), 1296.7, 235.79, 0, 239},
          {"trumpet", trumpet(), 1427.4, 382.01, 0},
          {"trumpet, slack lip", trumpet(220), 555.9, 252.44, 0},
          {"trumpet, tight lip", trumpet(430), 3190.3, 513.01, 0},
          {"trombone", trombone(), 1099.5, 216.72, 0},
          {"voice", voice(), 757.8, 117.64, 0},
          {"syrinx", syrinx(), 248.4, 1052.6, 0}};
}

/// Below the threshold, and with the reed shut at 9 kPa, where the bore rings alone.
inline std::vector<LinearState> decays() {
  return {{"clarinet", clarinet(), 1300, 171.96, -18.7},
          {"clarinet", clarinet(), 1428, 171.96, -4.59},
          {"short clarinet", clarinet(0.3), 1362, 272.31, -12.18},
          {"voice", voice(), 720, 117.64, -1.88}};
}
inline std::vector<LinearState> ring_downs() {
  return {{"0.30 m", clarinet(0.30), 9000, 278.25, -22.55},
          {"0.48 m", clarinet(0.48), 9000, 174.30, -17.70},
          {"0.60 m", clarinet(0.60), 9000, 139.43, -15.80},
          {"1.00 m", clarinet(1.00), 9000, 83.46, -12.20}};
}

/// Where pressures and spring balance.
struct RestState {
  Parameters parameters;
  double pressure, theta, flow; // Pa, rad, m^3/s
};
inline std::vector<RestState> rests() {
  return {{clarinet(), 700, -0.032899, 1.45798e-4},
          {trumpet(), 300, 0.013489, 2.40828e-5},
          {voice(), 300, 0.027388, 8.55706e-5}};
}

} // namespace tactus::reed::reference
