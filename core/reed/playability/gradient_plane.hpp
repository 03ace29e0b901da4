#pragma once

#include "core/dsp/elementary.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <algorithm>
#include <array>

namespace tactus::reed {

/// Maps the plane in which the hand moves, y and z in [0, 1], to mouth pressure and reed frequency.
struct ControlRange {
  double lowest_pressure = 0;     // p_lo, Pa
  double highest_pressure = 8000; // p_hi
  double lowest_frequency = 80;   // f_lo, Hz
  double highest_frequency = 900; // f_hi

  /// Linear in y.
  [[nodiscard]] double pressure(double y) const noexcept {
    return lowest_pressure + y * (highest_pressure - lowest_pressure);
  }
  /// Even steps of z are even musical intervals.
  [[nodiscard]] double frequency(double z) const noexcept {
    return lowest_frequency * math::pow(highest_frequency / lowest_frequency, z);
  }
};

/// Gradient of a quantity, per unit of y and of z.
struct Gradient {
  double y = 0, z = 0;
};

/// The five points of the central differences (Smyth, Smyth & Kirkpatrick, eq. 6): the hand's
/// position and one neighbour on each side in y and in z. At the edge of the plane a neighbour lies
/// on the edge, and the difference is divided by the actual distance.
struct GradientStencil {
  static constexpr int kPoints = 5;
  std::array<double, kPoints> y{}, z{}; // hand, y + delta, y - delta, z + delta, z - delta

  GradientStencil(double hand_y, double hand_z, double delta) noexcept {
    const auto inside = [](double x) { return x > 0 ? std::min(x, 1.0) : 0.0; };
    y.fill(inside(hand_y));
    z.fill(inside(hand_z));
    y[1] = inside(y[0] + delta);
    y[2] = inside(y[0] - delta);
    z[3] = inside(z[0] + delta);
    z[4] = inside(z[0] - delta);
  }

  /// (f(y + delta) - f(y - delta))/(2 delta), and the same in z; delta > 0.
  [[nodiscard]] Gradient gradient(const std::array<double, kPoints>& f) const noexcept {
    return {(f[1] - f[2]) / (y[1] - y[2]), (f[3] - f[4]) / (z[3] - z[4])};
  }
};

/// The range of mouth pressure and reed frequency in which an instrument plays. Blown closed: up to
/// 1.25 times the closing pressure, 0.4 to 1.4 times the reed frequency. Other valves: up to 5.6
/// times the lowest threshold, 0.25 to 2.75 times their frequency, so that lips find several
/// registers. Pressures are rounded to 100 Pa. Takes some milliseconds.
[[nodiscard]] ControlRange range_for(const Parameters& parameters) noexcept;

} // namespace tactus::reed
