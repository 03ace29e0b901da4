#include "core/reed/bore/woodwind.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/bore/air.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kEndCorrection = 0.02;  // m
constexpr double kWidestHole = 0.9;      // share of the bore's radius
constexpr double kBenade = 0.11;         // f_c = 0.11 c (b/a) sqrt(1/(s t_e)),
constexpr double kOuterCorrection = 1.5; // t_e = t + 1.5 b, s half the distance to the next hole

constexpr Woodwind kClarinetHoles{
    .lowest_key = 50,
    .highest_key = 70,
    .input_radius = 7.5e-3,
    .apex = 0,
    .cutoff = 1500,
    .chimney = 8e-3,
    .bell = {{{0, 1}, {0.02, 1.15}, {0.06, 1.6}, {0.10, 2.6}, {0.125, 4.0}}},
    .bell_corners = 5,
    .vent = {0.11, 1.5e-3, 12e-3},
    .overblow_interval = 19};
constexpr Woodwind kSaxophoneHoles{.lowest_key = 44,
                                   .highest_key = 76,
                                   .input_radius = 6.2e-3,
                                   .apex = 0.2,
                                   .cutoff = 800,
                                   .chimney = 4e-3,
                                   .cutoff_rise = 0.5,
                                   .cutoff_top = 59,
                                   .bell = {{{0, 1}, {0.06, 1.48}}},
                                   .bell_corners = 2,
                                   .vent = {0.16, 1.5e-3, 4e-3},
                                   .overblow_interval = 12};
constexpr Woodwind kOboeHoles{.lowest_key = 58,
                              .highest_key = 88,
                              .input_radius = 3e-3,
                              .apex = 0.1,
                              .cutoff = 1500,
                              .chimney = 5e-3,
                              .bell = {{{0, 1}, {0.04, 1.1}, {0.08, 1.4}}},
                              .bell_corners = 3,
                              .vent = {0.12, 0.6e-3, 5e-3},
                              .overblow_interval = 12};

} // namespace

double Woodwind::position(double key) const noexcept {
  const double frequency = 440 * math::exp2((key - 69) / 12);
  return air_at(20).sound_speed / ((apex > 0 ? 2 : 4) * frequency) - kEndCorrection;
}

double Woodwind::cutoff_at(int key) const noexcept {
  const double octaves = (std::clamp(key, lowest_key, cutoff_top) - lowest_key) / 12.0;
  return cutoff * math::exp2(cutoff_rise * octaves);
}

Woodwind::Hole Woodwind::tone_hole(std::size_t index) const noexcept {
  const int key = key_of(index);
  const double here = position(key), spacing = position(key - 1) - here;
  const double bore = radius(here);
  double ratio = 0.5;
  for (int i = 0; i < 50; ++i) {
    const double thickness = chimney + kOuterCorrection * ratio * bore;
    ratio =
        cutoff_at(key) / (kBenade * air_at(20).sound_speed) * std::sqrt(spacing / 2 * thickness);
  }
  return {here, std::min(ratio, kWidestHole) * bore, chimney};
}

const Woodwind* woodwind(BoreEnd end) noexcept {
  switch (end) {
  case BoreEnd::kClarinet:
    return &kClarinetHoles;
  case BoreEnd::kSaxophone:
    return &kSaxophoneHoles;
  case BoreEnd::kOboe:
    return &kOboeHoles;
  case BoreEnd::kOpen:
  case BoreEnd::kTrumpet:
  case BoreEnd::kTrombone:
    break;
  }
  return nullptr;
}

} // namespace tactus::reed
