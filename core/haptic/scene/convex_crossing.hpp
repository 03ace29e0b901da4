#pragma once

#include "core/haptic/scene/crossing.hpp"

#include <optional>

namespace tactus::haptic {

/// Where a sphere that moves along a straight line first touches a convex set, up to that fraction
/// of the motion. `nearest(p)` gives the point of the set nearest to p, p itself inside.
///
/// The distance d to a convex set is a convex function of the position, with the unit gradient
/// (p - nearest)/d outside of the set (Rockafellar, Convex Analysis, 1970). Newton's method for
/// d = radius from the side where d > radius then approaches the first solution from that side: the
/// tangent of a convex function lies below it. No iterate is ever past the contact, so that
/// stopping early is safe; convergence is quadratic, but for a grazing contact.
///
/// Where the motion begins with an overlap it may leave but not go deeper: the crossing is at 0.
/// With the sphere's centre inside of the set there is no contact. The radius must be > 0.
template <class Nearest>
[[nodiscard]] std::optional<Crossing>
convex_crossing(double radius, const Vec3& from, const Vec3& to, double limit,
                const Nearest& nearest, WorkLimit& work) noexcept {
  constexpr int kMaxIterations = 40;
  constexpr double kTouching_m = 1e-13; // a tenth of the gap that a proxy keeps
  const Vec3 motion = to - from;
  double fraction = 0;
  Vec3 normal;
  for (int i = 0; i < kMaxIterations; ++i) {
    work.spend(kIterationWork);
    const Vec3 at = from + motion * fraction, gap = at - nearest(at);
    const double distance = std::sqrt(dot(gap, gap));
    if (!(distance > 0.0))
      return {};
    normal = gap * (1.0 / distance);
    const double slope = dot(motion, normal);
    if (!(slope < 0.0)) // never nearer than here
      return {};
    if (distance - radius <= kTouching_m)
      break;
    fraction += (distance - radius) / -slope;
    if (fraction > limit)
      return {};
  }
  return Crossing{fraction, normal};
}

} // namespace tactus::haptic
