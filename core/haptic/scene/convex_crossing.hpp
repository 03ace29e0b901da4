#pragma once

#include "core/geometry/vec3.hpp"
#include "core/haptic/scene/work_limit.hpp"

#include <optional>

namespace tactus::haptic {

/// The first contact of a straight motion with a surface: the fraction of the motion, 0..1, and the
/// surface's unit normal on the side from which the motion comes.
struct Crossing {
  double fraction;
  Vec3 normal;
};

/// Cost of one iteration of convex_crossing, in units of WorkLimit.
inline constexpr int kIterationWork = 5;

/// Where a sphere of this radius (> 0) on a straight motion first touches a convex set, between the
/// fractions `begin` and `limit` of the motion. Before `begin` the sphere does not touch the set.
/// `nearest(p)` returns the point of the set nearest to p, which is p itself inside the set.
///
/// The distance d to a convex set is a convex function of the position, with the unit gradient (p -
/// nearest)/d outside of the set (Rockafellar, Convex Analysis, 1970). The tangent of a convex
/// function lies below it, so that Newton's method for d = radius, started where d > radius, never
/// passes the first solution: stopping early is safe. Convergence is quadratic except for a grazing
/// contact.
///
/// A motion that begins with an overlap and goes deeper has its crossing at 0; a motion that leaves
/// the set has none. With the sphere's centre inside the set there is no crossing.
template <class Nearest>
[[nodiscard]] std::optional<Crossing>
convex_crossing(double radius, const Vec3& from, const Vec3& to, double begin, double limit,
                const Nearest& nearest, WorkLimit& work) noexcept {
  constexpr int kMaxIterations = 40;
  constexpr double kTouching_m = 1e-13; // a tenth of Proxy::kSkin_m
  const Vec3 motion = to - from;
  double fraction = begin;
  Vec3 normal;
  for (int i = 0; i < kMaxIterations; ++i) {
    work.spend(kIterationWork);
    const Vec3 at = from + motion * fraction, gap = at - nearest(at);
    const double distance = std::sqrt(dot(gap, gap));
    if (!(distance > 0.0))
      return {};
    normal = gap * (1.0 / distance);
    const double slope = dot(motion, normal);
    if (!(slope < 0.0)) // the distance does not fall any more
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
