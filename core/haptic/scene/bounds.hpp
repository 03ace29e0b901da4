#pragma once

#include "core/haptic/scene/pose.hpp"

#include <array>
#include <limits>

namespace tactus::haptic {

/// An axis-aligned bounding box, m.
struct Bounds {
  Vec3 low{}, high{};
};

/// A straight motion between two points, with values computed in advance for tests against many
/// boxes.
class Segment {
public:
  Segment(const Vec3& from, const Vec3& to) noexcept : from_(from) {
    for (int axis = 0; axis < 3; ++axis) {
      const double inverse = 1.0 / (to[axis] - from[axis]);
      inverse_[axis] = std::isfinite(inverse) ? inverse : 0.0;
    }
  }

  static constexpr double kNever = std::numeric_limits<double>::infinity();
  /// The fraction of the motion at which the moving point may first touch the box, grown by a
  /// margin on all sides; kNever if this fraction is beyond `limit`. Slab method (Kay & Kajiya,
  /// SIGGRAPH 1986), with the slabs a few ulp wider, so that a triangle in the face of its box is
  /// found in spite of rounding.
  [[nodiscard]] double entry(const Bounds& bounds, double margin, double limit) const noexcept {
    double begin = 0.0, end = limit;
    for (int axis = 0; axis < 3; ++axis) {
      const double low = bounds.low[axis] - margin - from_[axis],
                   high = bounds.high[axis] + margin - from_[axis];
      if (inverse_[axis] == 0.0) { // parallel to the slab
        if (low > 0.0 || high < 0.0)
          return kNever;
        continue;
      }
      const double one = low * inverse_[axis], other = high * inverse_[axis];
      begin = std::max(begin, std::min(one, other) * (1.0 - kSlack));
      end = std::min(end, std::max(one, other) * (1.0 + kSlack));
    }
    return begin <= end ? begin : kNever;
  }

private:
  static constexpr double kSlack = 1e-15;
  Vec3 from_{}, inverse_{}; ///< 1/0 stored as 0
};

/// The squared distance from a point to a box; 0 inside. m^2
[[nodiscard]] inline double squared_distance(const Bounds& bounds, const Vec3& p) noexcept {
  Vec3 gap;
  for (int axis = 0; axis < 3; ++axis)
    gap[axis] = std::max({bounds.low[axis] - p[axis], p[axis] - bounds.high[axis], 0.0});
  return dot(gap, gap);
}

} // namespace tactus::haptic
