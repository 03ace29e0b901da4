#include "core/reed/woodwind.hpp"

#include "core/reed/air.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kEndCorrection = 0.02;  // m
constexpr double kWidestHole = 0.9;      // of the bore's radius
constexpr double kBenade = 0.11;         // f_c = 0.11 c (b/a) sqrt(1/(s t_e)),
constexpr double kOuterCorrection = 1.5; // t_e = t + 1.5 b, s half the distance to the next hole

constexpr Woodwind kClarinet{
    .lowest_key = 50,
    .highest_key = 70,
    .input_radius = 7.5e-3,
    .apex = 0,
    .cutoff = 1500,
    .chimney = 8e-3,
    .bell = {{{0, 1}, {0.02, 1.15}, {0.06, 1.6}, {0.10, 2.6}, {0.125, 4.0}}},
    .bell_corners = 5,
    .vent = {0.11, 1.5e-3, 12e-3},
    .overblown = 19};
constexpr Woodwind kSaxophone{.lowest_key = 46,
                              .highest_key = 75,
                              .input_radius = 6.2e-3,
                              .apex = 0.2,
                              .cutoff = 800,
                              .chimney = 4e-3,
                              .bell = {{{0, 1}, {0.10, 1.25}, {0.18, 2.2}}},
                              .bell_corners = 3,
                              .vent = {0.16, 1.5e-3, 4e-3},
                              .overblown = 12};
constexpr Woodwind kOboe{.lowest_key = 57,
                         .highest_key = 81,
                         .input_radius = 3e-3,
                         .apex = 0.1,
                         .cutoff = 1500,
                         .chimney = 5e-3,
                         .bell = {{{0, 1}, {0.05, 1.2}, {0.09, 1.7}}},
                         .bell_corners = 3,
                         .vent = {0.12, 0.6e-3, 5e-3},
                         .overblown = 12};

} // namespace

double Woodwind::place(double key) const noexcept {
  const double frequency = 440 * std::exp2((key - 69) / 12);
  return air_at(20).sound_speed / ((apex > 0 ? 2 : 4) * frequency) - kEndCorrection;
}

Woodwind::Hole Woodwind::tone_hole(std::size_t index) const noexcept {
  const double key = key_of(index), here = place(key), spacing = place(key - 1) - here;
  const double bore = radius(here);
  double ratio = 0.5;
  for (int i = 0; i < 50; ++i) {
    const double thickness = chimney + kOuterCorrection * ratio * bore;
    ratio = cutoff / (kBenade * air_at(20).sound_speed) * std::sqrt(spacing / 2 * thickness);
  }
  return {here, std::min(ratio, kWidestHole) * bore, chimney};
}

const Woodwind* woodwind(BoreEnd end) noexcept {
  switch (end) {
  case BoreEnd::kClarinet:
    return &kClarinet;
  case BoreEnd::kSaxophone:
    return &kSaxophone;
  case BoreEnd::kOboe:
    return &kOboe;
  case BoreEnd::kOpen:
    break;
  }
  return nullptr;
}

} // namespace tactus::reed
