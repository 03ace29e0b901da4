#include "core/reed/instrument/parameters.hpp"

#include "core/reed/bore/air.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <limits>
#include <numbers>

namespace tactus::reed {
namespace {

/// The value within its bounds; what is no number becomes the fallback.
double bounded(double value, double low, double high, double fallback) {
  if (!std::isfinite(value))
    return fallback;
  return value < low ? low : value > high ? high : value;
}

} // namespace

Parameters clamped(const Parameters& parameters) noexcept {
  constexpr Parameters kInitial;
  Parameters p = parameters;
  p.rest_angle = bounded(p.rest_angle, -1.5, 1.5, kInitial.rest_angle);
  if (p.type == ValveType::kClosed)
    p.rest_angle = -std::abs(p.rest_angle);
  else if (p.type == ValveType::kOpen)
    p.rest_angle = std::abs(p.rest_angle);
  p.arm_length = bounded(p.arm_length, 1e-4, 0.1, kInitial.arm_length);
  p.mass = bounded(p.mass, 1e-9, 1, kInitial.mass);
  p.reed_frequency = bounded(p.reed_frequency, 1, 20000, kInitial.reed_frequency);
  p.quality = bounded(p.quality, 0.1, 1000, kInitial.quality);
  p.width = bounded(p.width, 1e-5, 0.1, kInitial.width);
  p.mouth_length = bounded(p.mouth_length, 0, 0.1, kInitial.mouth_length);
  p.bore_length = bounded(p.bore_length, 0, 0.1, kInitial.bore_length);
  p.flow_length = bounded(p.flow_length, 0, 0.1, kInitial.flow_length);
  p.channel_length = bounded(p.channel_length, 1e-7, 0.1, kInitial.channel_length);
  p.leak_area = bounded(p.leak_area, 0, 1e-3, kInitial.leak_area);
  p.restitution = bounded(p.restitution, 0, 1, kInitial.restitution);
  p.displacement_limit = bounded(p.displacement_limit, 1e-6, 0.05, kInitial.displacement_limit);
  p.length = bounded(p.length, 0.005, 22, kInitial.length);
  p.length_override = bounded(p.length_override, 0, 22, kInitial.length_override);
  p.input_radius = bounded(p.input_radius, 1e-4, 0.2, kInitial.input_radius);
  p.end_radius = bounded(p.end_radius, 1e-4, 0.5, kInitial.end_radius);
  p.apex_distance = bounded(p.apex_distance, 1e-3, 100, kInitial.apex_distance);
  p.cup_volume = bounded(p.cup_volume, 0, 1e-3, kInitial.cup_volume);
  p.wall_loss = bounded(p.wall_loss, 0, 100, kInitial.wall_loss);
  p.bell = bounded(p.bell, 0, 20000, kInitial.bell);
  p.bell_quality = bounded(p.bell_quality, 0.1, 100, kInitial.bell_quality);
  p.brassiness = bounded(p.brassiness, 0, 100, kInitial.brassiness);
  p.scalar_reflection = bounded(p.scalar_reflection, 0, 1, kInitial.scalar_reflection);
  p.temperature = bounded(p.temperature, -50, 100, kInitial.temperature);
  p.fingering = bounded(p.fingering, 0, 127, kInitial.fingering);
  p.valves = p.valves < -1 || p.valves > 7 ? -1 : p.valves;
  p.slide = p.slide > 0 ? bounded(p.slide, 1, 7, kInitial.slide) : 0;
  p.breath_noise = bounded(p.breath_noise, 0, 10, kInitial.breath_noise);
  p.embouchure = bounded(p.embouchure, 0, 10, kInitial.embouchure);
  p.embouchure_slope = bounded(p.embouchure_slope, -2, 2, kInitial.embouchure_slope);
  p.highest_mode = bounded(p.highest_mode, 0, 100, kInitial.highest_mode);
  p.shortest_tract = bounded(p.shortest_tract, 0, 100, kInitial.shortest_tract);
  p.steepening = bounded(p.steepening, 0, 100, kInitial.steepening);
  p.aim = bounded(p.aim, -1200, 1200, kInitial.aim);
  for (double Parameters::*lip :
       {&Parameters::lip_mass, &Parameters::lip_opening, &Parameters::lip_width,
        &Parameters::lip_quality, &Parameters::lip_channel, &Parameters::lip_cup,
        &Parameters::lip_limit})
    p.*lip = bounded(p.*lip, 0.01, 100, 1);
  p.played_gain = bounded(p.played_gain, 0, 100, kInitial.played_gain);
  p.tongue = bounded(p.tongue, 0, 3, kInitial.tongue);
  p.breath_reference = bounded(p.breath_reference, 0, 50e3, kInitial.breath_reference);
  p.breath_opening = bounded(p.breath_opening, 0, 2, kInitial.breath_opening);
  p.breath_tension = bounded(p.breath_tension, 0, 2, kInitial.breath_tension);
  p.breath_quality = bounded(p.breath_quality, -2, 2, kInitial.breath_quality);
  p.register_note = bounded(p.register_note, 0, 20000, kInitial.register_note);
  p.lowest_note = bounded(p.lowest_note, 0, 20000, kInitial.lowest_note);
  p.highest_note = bounded(p.highest_note, 0, 20000, kInitial.highest_note);
  p.gain = bounded(p.gain, 0, 1e6, kInitial.gain);
  return p;
}

Parameters interpolate(const Parameters& from, const Parameters& to, double share) noexcept {
  Parameters p = to;
  for (double Parameters::*member : {&Parameters::rest_angle,     &Parameters::arm_length,
                                     &Parameters::mass,           &Parameters::reed_frequency,
                                     &Parameters::width,          &Parameters::mouth_length,
                                     &Parameters::bore_length,    &Parameters::flow_length,
                                     &Parameters::channel_length, &Parameters::leak_area,
                                     &Parameters::restitution,    &Parameters::displacement_limit,
                                     &Parameters::length,         &Parameters::input_radius,
                                     &Parameters::end_radius,     &Parameters::apex_distance,
                                     &Parameters::cup_volume,     &Parameters::wall_loss,
                                     &Parameters::bell,           &Parameters::bell_quality,
                                     &Parameters::brassiness,     &Parameters::scalar_reflection,
                                     &Parameters::temperature,    &Parameters::breath_noise})
    p.*member = from.*member + share * (to.*member - from.*member);
  return p;
}

namespace {

using Size = double Parameters::*;
constexpr double kSlope = 0.1; // of the embouchure

bool within(double factor, std::initializer_list<Size> sizes, const Parameters& a,
            const Parameters& b) {
  return std::all_of(sizes.begin(), sizes.end(), [&](Size size) {
    const double one = std::abs(a.*size), other = std::abs(b.*size);
    return one <= factor * other && other <= factor * one;
  });
}

} // namespace

bool can_continue(const Parameters& a, const Parameters& b) noexcept {
  constexpr double kFactor = 2;
  return a.type == b.type && a.shape == b.shape && a.tune == b.tune &&
         oversampling_of(a) == oversampling_of(b) &&
         within(kFactor,
                {&Parameters::arm_length, &Parameters::mass, &Parameters::width,
                 &Parameters::mouth_length, &Parameters::bore_length, &Parameters::input_radius,
                 &Parameters::apex_distance, &Parameters::scalar_reflection,
                 &Parameters::length_override},
                a, b) &&
         (!a.tune || (std::abs(a.embouchure_slope - b.embouchure_slope) <= kSlope &&
                      within(kFactor,
                             {&Parameters::embouchure, &Parameters::breath_reference,
                              &Parameters::lip_mass, &Parameters::lip_width},
                             a, b)));
}

bool can_interpolate(const Parameters& a, const Parameters& b) noexcept {
  constexpr double kFactor = 1.25;
  constexpr double kCents = 100;
  if (a.type != b.type || a.shape != b.shape || a.end != b.end || a.flow != b.flow ||
      a.sweep != b.sweep || a.tune != b.tune || oversampling_of(a) != oversampling_of(b))
    return false;
  // These may differ by more and still glide: a rest position acts as a force, losses as a factor.
  constexpr double kAngle = 0.1;
  constexpr double kNearSlope = 0.05;
  constexpr double kLosses = 10;
  if (std::abs(a.rest_angle - b.rest_angle) > kAngle || a.quality > kLosses * b.quality ||
      b.quality > kLosses * a.quality)
    return false;
  return within(kFactor, {&Parameters::arm_length,       &Parameters::mass,
                          &Parameters::reed_frequency,   &Parameters::width,
                          &Parameters::mouth_length,     &Parameters::bore_length,
                          &Parameters::flow_length,      &Parameters::channel_length,
                          &Parameters::leak_area,        &Parameters::displacement_limit,
                          &Parameters::length,           &Parameters::length_override,
                          &Parameters::input_radius,     &Parameters::end_radius,
                          &Parameters::apex_distance,    &Parameters::cup_volume,
                          &Parameters::wall_loss,        &Parameters::bell,
                          &Parameters::bell_quality,     &Parameters::brassiness,
                          &Parameters::scalar_reflection},
                a, b) &&
         (!a.tune ||
          (a.correct_pitch == b.correct_pitch && a.tube == b.tube &&
           std::abs(a.aim - b.aim) <= kCents &&
           std::abs(a.embouchure_slope - b.embouchure_slope) <= kNearSlope &&
           within(kFactor,
                  {&Parameters::embouchure, &Parameters::lip_mass, &Parameters::lip_opening,
                   &Parameters::lip_width, &Parameters::lip_quality, &Parameters::breath_reference},
                  a, b)));
}

double note_of(const Parameters& p, double bore_frequency) noexcept {
  return p.tune && p.fingering > 0 ? 440 * std::exp2((p.fingering - 69) / 12) : bore_frequency;
}

int oversampling_of(const Parameters& p) noexcept {
  if (p.oversampling >= 4)
    return 4;
  if (p.oversampling >= 1)
    return p.oversampling == 1 ? 1 : 2;
  return p.type == ValveType::kSwinging ? 4 : 1;
}

double closing_pressure(const Parameters& p) noexcept {
  const double omega = 2 * std::numbers::pi * p.reed_frequency;
  const double force = p.mass * omega * omega * p.arm_length * std::abs(p.rest_angle);
  const double area = p.width * p.mouth_length;
  return area > 0 ? force / area : std::numeric_limits<double>::infinity();
}

double strength(const Parameters& p) noexcept {
  const Air air = air_at(p.temperature);
  const double impedance =
      air.density * air.sound_speed / (std::numbers::pi * p.input_radius * p.input_radius);
  const double opening = p.width * p.arm_length * std::abs(p.rest_angle);
  return impedance * opening * std::sqrt(2 / (air.density * closing_pressure(p)));
}

} // namespace tactus::reed
