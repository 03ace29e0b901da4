#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tactus::contact {

/// Random deviation of a strike from the intended one, as of a human player.
///
/// Each number is normally distributed and redrawn beyond two standard deviations. The standard
/// deviations at variation 1:
/// - logarithm of the speed: 0.12 (1 dB), between the even strokes of a drummer
///   and those of a beginner;
/// - direction: 4 degrees about each of the two axes normal to it;
/// - point: 1/40 of the body's largest extent along each of two axes of the surface, at most 8 mm.
///   Aimed hits on a target of width W have the standard deviation W / 4.13 (Fitts' law with
///   effective widths, ISO 9241-411); W is taken as a tenth of the body.
struct StrikeScatter {
  static constexpr double kSpeedSpread = 0.12;
  static constexpr double kAngleSpread = 4 * std::numbers::pi / 180;           // rad
  static constexpr double kPointShare = 1.0 / 40, kLargestPointSpread = 0.008; // m

  double speed_factor = 1;
  std::array<double, 2> tilt_rad{}, offset_m{};

  /// `extent_m`: largest extent of the body.
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
    scatter.speed_factor = math::exp(variation * kSpeedSpread * within_two());
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
