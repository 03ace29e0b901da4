#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

using haptic::Vec3;

/// A place on a triangulated surface.
struct SurfacePoint {
  std::size_t triangle = 0;
  std::array<double, 3> weight{1, 0, 0}; ///< of the triangle's corners, sum 1
  Vec3 position{};
  Vec3 normal{0, 0, 1}; ///< outwards, length 1
  double distance = 0;  ///< from the place that was asked for, m
};

/// Finds the place of a triangulated surface that is nearest to a point, by a tree of boxes.
/// Closest point of a triangle: Ericson, Real-Time Collision Detection, 5.1.5.
class Surface {
public:
  /// Allocates. The surface must have triangles, their corners within the vertices.
  void build(std::span<const Vec3> vertices,
             std::span<const std::array<std::int32_t, 3>> triangles);
  [[nodiscard]] bool empty() const noexcept { return corner_.empty(); }
  /// Never fails for a finite point; allocates nothing.
  [[nodiscard]] SurfacePoint nearest(const Vec3& point) const noexcept;
  /// A place by triangle and the weights u, v of its second and third corner.
  [[nodiscard]] SurfacePoint on(std::size_t triangle, double u, double v) const noexcept;
  [[nodiscard]] std::size_t triangles() const noexcept { return corner_.size(); }
  [[nodiscard]] const std::array<Vec3, 3>& corners(std::size_t triangle) const noexcept {
    return corner_[triangle];
  }
  [[nodiscard]] const Vec3& lowest() const noexcept { return boxes_[0].low; }
  [[nodiscard]] const Vec3& highest() const noexcept { return boxes_[0].high; }
  /// Of the box around the body.
  [[nodiscard]] double diagonal() const noexcept;

private:
  struct Box {
    Vec3 low, high;
    std::uint32_t first = 0, count = 0; // triangles of a leaf; count 0: two children from first on
  };
  [[nodiscard]] static double distance_squared(const Box& box, const Vec3& point) noexcept;
  void split(std::size_t box, std::size_t first, std::size_t last);

  std::vector<std::array<Vec3, 3>> corner_;
  std::vector<std::uint32_t> order_;
  std::vector<Box> boxes_;
};

/// The direction, of length 1, along a surface with this normal that is nearest to the one wanted.
/// One within 20 degrees of the plane is along: facets of a curved surface lie so far off it. Along
/// the normal there is none: the nearest to x or y then.
[[nodiscard]] Vec3 along_surface(const Vec3& normal, const Vec3& desired) noexcept;

} // namespace tactus::modal
