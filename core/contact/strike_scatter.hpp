#pragma once

#include "core/dsp/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tactus::contact {

/// How a strike misses what its striker meant: a hand neither aims nor swings twice alike.
///
/// Each number is normal, redrawn beyond twice its standard deviation. At variation 1 that is:
/// - of the speed's logarithm 0.12 (1 dB), between a drummer's even strokes and a beginner's;
/// - of the direction 4 degrees about each axis across it;
/// - of the point, along each of two axes of the surface, 1/40 of the body's largest extent, at
///   most 8 mm: who aims at a target W wide scatters by W / 4.13 (Fitts' law with effective widths,
///   ISO 9241-411), and a player means a tenth of the body.
struct StrikeScatter {
  static constexpr double kSpeedSpread = 0.12;
  static constexpr double kAngleSpread = 4 * std::numbers::pi / 180;           // rad
  static constexpr double kPointShare = 1.0 / 40, kLargestPointSpread = 0.008; // m

  double speed_factor = 1;
  std::array<double, 2> tilt_rad{}, offset_m{};

  /// `extent_m`: of the body.
  [[nodiscard]] static StrikeScatter draw(double variation, double extent_m,
                                          Random& random) noexcept {
    const auto within_two = [&random] {
      double x = random.normal();
      for (int round = 0; std::abs(x) > 2 && round < kMaxRounds; ++round)
        x = random.normal();
      return std::clamp(x, -2.0, 2.0);
    };
    const double point = variation * std::min(kPointShare * extent_m, kLargestPointSpread);
    StrikeScatter scatter;
    scatter.speed_factor = std::exp(variation * kSpeedSpread * within_two());
    for (std::size_t axis = 0; axis < 2; ++axis) {
      scatter.tilt_rad[axis] = variation * kAngleSpread * within_two();
      scatter.offset_m[axis] = point * within_two();
    }
    return scatter;
  }

private:
  static constexpr int kMaxRounds = 64;
};

} // namespace tactus::contact
