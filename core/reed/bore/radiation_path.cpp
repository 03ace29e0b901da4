#include "core/reed/bore/radiation_path.hpp"

#include "core/dsp/complex.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace tactus::reed {
namespace {

/// (1 - x)(n_0 + n_1 x), x = z^-1, as b_0 + b_1 x + b_2 x^2: it rises from 0 as `slope` times 1 -
/// x, and has the magnitude size(omega T, x) at 8 kHz.
template <class Size>
std::array<double, 3> numerator(double slope, double period, const Size& size) {
  const double omega = std::min(2 * std::numbers::pi * 8e3 * period, 2.0);
  const double back = 1 - math::cos(omega), target = size(omega, math::polar(1.0, -omega));
  // |n_0 + n_1 x|^2 = slope^2 - 2 n_0 n_1 (1 - cos omega T).
  const double product = (slope * slope - target * target / (2 * back)) / (2 * back);
  const double n0 = 0.5 * (slope + std::sqrt(std::max(0.0, slope * slope - 4 * product)));
  const double n1 = slope - n0;
  return {n0, n1 - n0, -n1};
}

} // namespace

RadiationConstants RadiationConstants::from(const Parameters& p, const BoreDesign& bore,
                                            double internal_rate) noexcept {
  constexpr double kPi = std::numbers::pi;
  constexpr double kAtmosphere = 101325; // P_0, Pa
  RadiationConstants c;
  c.plain = !(p.bell > 0);
  c.rate = internal_rate;
  if (c.plain) {
    const double slope = bore.air().density / bore.impedance() / (4 * kPi);
    const auto [b0, b1, b2] =
        numerator(slope * internal_rate, 1 / internal_rate,
                  [&](double omega, Complex) { return slope * internal_rate * omega; });
    c.b0 = b0, c.b1 = b1, c.b2 = b2;
    return c;
  }
  const double speed = bore.air().sound_speed, period = 1 / internal_rate;
  const double cutoff = 2 * kPi * std::min(p.bell, 0.4 * internal_rate);
  const double opening = p.shape == BoreShape::kCone
                             ? p.input_radius * (1 + p.length / p.apex_distance)
                             : p.input_radius;
  const double corner = cutoff * opening / speed; // corner frequency relative to w_c
  // Its poles are w_c (-g +- sqrt(g^2 - 1)), g = 1/2Q.
  const double angle = cutoff * period, damping = 0.5 / p.bell_quality;
  const double decay = math::exp(-damping * angle), discriminant = 1 - damping * damping;
  c.a1 = -2 * decay *
         (discriminant >= 0 ? math::cos(angle * std::sqrt(discriminant))
                            : math::cosh(angle * std::sqrt(-discriminant)));
  c.a2 = decay * decay;
  const double scale = 0.5 * p.input_radius;
  const auto [b0, b1, b2] = numerator(
      scale * corner / angle * (1 + c.a1 + c.a2), period, [&](double omega, Complex back) {
        const Complex s(0, omega / angle);
        return scale * math::abs(s * (s + corner) / (s * s + 2 * damping * s + 1.0) *
                                 (1.0 + back * (c.a1 + back * c.a2)));
      });
  c.b0 = b0, c.b1 = b1, c.b2 = b2;
  c.lead = (kHeatCapacityRatio + 1) / (2 * kHeatCapacityRatio * kAtmosphere * speed) *
           p.brassiness * internal_rate;
  return c;
}

RadiationConstants RadiationConstants::interpolate(const RadiationConstants& from,
                                                   const RadiationConstants& to,
                                                   double share) noexcept {
  RadiationConstants c = to;
  for (double RadiationConstants::*member :
       {&RadiationConstants::b0, &RadiationConstants::b1, &RadiationConstants::b2,
        &RadiationConstants::a1, &RadiationConstants::a2, &RadiationConstants::lead})
    c.*member = from.*member + share * (to.*member - from.*member);
  return c;
}

} // namespace tactus::reed
