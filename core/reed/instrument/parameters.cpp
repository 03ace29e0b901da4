#include "core/reed/instrument/parameters.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/instrument/parameter_rows.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace tactus::reed {
namespace {

/// True if both sizes agree within the factor.
bool within_factor(double factor, double a, double b) {
  const double one = std::abs(a), other = std::abs(b);
  return factor >= Change::kAny || (one <= factor * other && other <= factor * one);
}

} // namespace

Parameters clamped(const Parameters& parameters) noexcept {
  Parameters p = parameters;
  for (const Row& row : kRows)
    if (!row.seeds) {
      const double value = row.get(&p);
      row.set(&p, std::isfinite(value) ? std::clamp(value, row.lowest, row.highest) : row.initial);
    }
  p.orient();
  p.valves = p.valves < -1 || p.valves > 7 ? -1 : p.valves;
  if (p.slide > 0)
    p.slide = std::max(p.slide, 1.0);
  return p;
}

Parameters interpolate(const Parameters& from, const Parameters& to, double share) noexcept {
  Parameters p = to;
  for (const Row& row : kRows)
    if (row.change.glide) {
      const double begin = row.get(&from);
      row.set(&p, begin + share * (row.get(&to) - begin));
    }
  return p;
}

bool can_continue(const Parameters& a, const Parameters& b) noexcept {
  return oversampling_of(a) == oversampling_of(b) &&
         std::all_of(kRows.begin(), kRows.end(), [&](const Row& row) {
           const double one = row.get(&a), other = row.get(&b);
           return (row.change.of_player && !a.tune) ||
                  (within_factor(row.change.continued_factor, one, other) &&
                   std::abs(one - other) <= row.change.continued_step);
         });
}

bool can_interpolate(const Parameters& a, const Parameters& b) noexcept {
  return oversampling_of(a) == oversampling_of(b) &&
         std::all_of(kRows.begin(), kRows.end(), [&](const Row& row) {
           const double one = row.get(&a), other = row.get(&b);
           return (row.change.of_player && !a.tune) ||
                  (within_factor(row.change.factor, one, other) &&
                   std::abs(one - other) <= row.change.step);
         });
}

double note_of(const Parameters& p, double bore_frequency) noexcept {
  return p.tune && p.fingering > 0 ? 440 * math::exp2((p.fingering - 69) / 12) : bore_frequency;
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
