#pragma once

#include "core/geometry/vec3.hpp"

namespace tactus::haptic {

/// Positions of a source that reports less often than the servo ticks, as a motion without steps:
/// from the present position straight to the reported one.
///
///   x(t) = x_0 + (x_n - x_0) min(1, (t - t_n)/D),   D = kStretch I
///
/// t_n, x_n: time and position of the newest report; x_0: where the glide was at t_n; I: time
/// between the last two reports. With reports of a steady motion v, each I apart, the lag settles
/// at D v and the speed of the glide at v exactly: a remainder r before a report leaves
/// (r + v I)(1 - 1/kStretch), whose fixed point is r = (kStretch - 1) v I, and (r + v I)/D = v.
/// kStretch > 1 keeps it moving where a report is late by up to the quarter of I.
///
/// A source may send the same position again, or none while it rests: only a changed position
/// counts as a report. After a pause of more than kMaxInterval_s I is kUsualInterval_s.
/// Units m and s. Bounded for any input, allocates nothing; use in one thread.
class LinearGlide {
public:
  static constexpr double kStretch = 1.25;
  static constexpr double kUsualInterval_s = 0.01;
  static constexpr double kMinInterval_s = 1e-3, kMaxInterval_s = 0.04;

  /// Forgets all: the next position is taken at once.
  void reset() noexcept { *this = {}; }
  /// The newest position known at time_s -> the position of the glide. A position or time that is
  /// not finite, and a time before the last one, change nothing.
  Vec3 update(const Vec3& reported, double time_s) noexcept;

private:
  [[nodiscard]] Vec3 at(double time_s) const noexcept;

  Vec3 start_{}, target_{}, position_{};
  double report_s_ = 0, duration_s_ = 0, time_s_ = 0;
  bool started_ = false;
};

} // namespace tactus::haptic
