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
    50, 70, 7.5e-3, 0, 1500, 8e-3, {{{0, 1}, {0.02, 1.15}, {0.06, 1.6}, {0.10, 2.6}, {0.125, 4.0}}},
    5};
constexpr Woodwind kSaxophone{46, 75, 6.2e-3, 0.2, 800, 4e-3, {{{0, 1}, {0.10, 1.25}, {0.18, 2.2}}},
                              3};
constexpr Woodwind kOboe{57, 81, 3e-3, 0.1, 1500, 5e-3, {{{0, 1}, {0.05, 1.2}, {0.09, 1.7}}}, 3};

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
