#pragma once

#include "core/geometry/vec3.hpp"

namespace tactus::haptic {

/// Linear interpolation of positions that arrive less often than the servo ticks: from the present
/// position straight to the newest report, so that the motion has no steps.
///
///   x(t) = x_0 + (x_n - x_0) min(1, (t - t_n)/D),   D = kStretch I
///
/// t_n, x_n: time and position of the newest report; x_0: the output at t_n; I: time between the
/// last two reports. For a steady velocity v, reported every I, the lag converges to D v and the
/// velocity of the output to v: a distance r that remains before a report becomes
/// (r + v I)(1 - 1/kStretch) before the next; the fixed point is r = (kStretch - 1) v I, and there
/// (r + v I)/D = v. kStretch = 1.25 keeps the output moving when a report is late by up to I/4.
///
/// Only a changed position counts as a report, since a source may repeat a position or send none
/// while it is at rest. After a pause longer than kMaxInterval_s, I is kUsualInterval_s.
/// Units m and s. Bounded for any input, allocates nothing; for one thread.
class LinearGlide {
public:
  static constexpr double kStretch = 1.25;
  static constexpr double kUsualInterval_s = 0.01;
  static constexpr double kMinInterval_s = 1e-3, kMaxInterval_s = 0.04;

  /// The next position is then returned without interpolation.
  void reset() noexcept { *this = {}; }
  /// The interpolated position at time_s, given the newest position known then. A position or time
  /// that is not finite, or a time before the last one, changes nothing.
  Vec3 update(const Vec3& reported, double time_s) noexcept;

private:
  [[nodiscard]] Vec3 at(double time_s) const noexcept;

  Vec3 start_{}, target_{}, position_{};
  double report_s_ = 0, duration_s_ = 0, time_s_ = 0;
  bool started_ = false;
};

} // namespace tactus::haptic
