#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace tactus::modal {

/// A point on a triangulated surface.
struct SurfacePoint {
  std::size_t triangle = 0;
  std::array<double, 3> weight{1, 0, 0}; ///< barycentric, of the triangle's corners; sum 1
  Vec3 position{};
  Vec3 normal{0, 0, 1}; ///< outwards, length 1
  double distance = 0;  ///< of nearest(): distance from the given point, m
};

/// A triangulated surface that finds its nearest point to a given point, by a bounding volume
/// hierarchy of axis-aligned boxes. Nearest point of a triangle: Ericson, Real-Time Collision
/// Detection, 2005, section 5.1.5. Units m.
class Surface {
public:
  /// Allocates. Every triangle holds three indices into `vertices`. Without triangles empty() is
  /// true, and the queries below must not be called.
  void build(std::span<const Vec3> vertices,
             std::span<const std::array<std::int32_t, 3>> triangles);
  [[nodiscard]] bool empty() const noexcept { return corner_.empty(); }
  /// Never fails for a finite point; allocates nothing.
  [[nodiscard]] SurfacePoint nearest(const Vec3& point) const noexcept;
  /// The point of a triangle by the barycentric weights u, v of its second and third corner.
  [[nodiscard]] SurfacePoint on(std::size_t triangle, double u, double v) const noexcept;
  [[nodiscard]] std::size_t triangles() const noexcept { return corner_.size(); }
  [[nodiscard]] const std::array<Vec3, 3>& corners(std::size_t triangle) const noexcept {
    return corner_[triangle];
  }
  /// Opposite corners of the axis-aligned box around the surface, and the distance between them.
  [[nodiscard]] const Vec3& lowest() const noexcept { return boxes_[0].low; }
  [[nodiscard]] const Vec3& highest() const noexcept { return boxes_[0].high; }
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

/// The unit vector tangent to a surface with this unit normal that is nearest to `desired`. A
/// direction within 20 degrees of the tangent plane is returned unchanged, because the facets of a
/// coarse mesh of a curved surface deviate by as much. If `desired` has no usable tangential part
/// (it is zero or along the normal), the tangential part of the x axis replaces it, else that of
/// the y axis.
[[nodiscard]] Vec3 along_surface(const Vec3& normal, const Vec3& desired) noexcept;

} // namespace tactus::modal
