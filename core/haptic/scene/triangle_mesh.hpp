#pragma once

#include "core/haptic/scene/bounds.hpp"
#include "core/haptic/scene/convex_crossing.hpp"

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace tactus::haptic {

using Triangle = std::array<std::uint32_t, 3>;

/// A triangle mesh with a bounding volume hierarchy of axis-aligned boxes (for a point) and flat
/// cylinders (for a sphere), for collision tests in the servo. The constructor allocates;
/// afterwards the mesh is constant and any thread may read it. Every query counts its work
/// (WorkLimit). Units m. triangle_mesh_queries.cpp has the queries.
class TriangleMesh {
public:
  /// Grid on which corners are merged; a triangle that then has no area is left out.
  static constexpr double kWeld_m = 1e-6;

  TriangleMesh(std::span<const Vec3> corners_m, std::span<const Triangle> triangles);

  /// The first triangle that a point meets between two positions. Watertight: an edge shared by two
  /// triangles is tested with the same rounding for both, so that no motion passes between them. If
  /// several triangles are met at the same fraction, the last one in the mesh's own order counts.
  [[nodiscard]] std::optional<Crossing> crossing(const Vec3& from, const Vec3& to,
                                                 WorkLimit& work) const noexcept;
  /// The first triangle that a sphere of this radius (> 0) meets, by convex_crossing.hpp; `from`,
  /// `to` and the crossing refer to the sphere's centre.
  [[nodiscard]] std::optional<Crossing> crossing(double radius, const Vec3& from, const Vec3& to,
                                                 WorkLimit& work) const noexcept;
  struct Nearest {
    Vec3 point;
    double distance;
    Vec3 face_normal; ///< normal of its triangle, of unit length
  };
  /// The point of the surface nearest to p, if it is nearer than the limit.
  [[nodiscard]] std::optional<Nearest> nearest(const Vec3& p, double limit,
                                               WorkLimit& work) const noexcept;

  [[nodiscard]] std::size_t size() const noexcept { return triangles_.size(); }
  [[nodiscard]] const Bounds& bounds() const noexcept { return bounds_; }

private:
  /// 32 bytes: bounds in single precision, rounded outwards. Siblings are adjacent, so that the
  /// nearest-first traversal reads both from one cache line.
  struct Node {
    std::array<float, 3> low, high;
    std::uint32_t first = 0; ///< leaf: its first triangle; else its first child, which the second
                             ///< child follows
    std::uint32_t count = 0; ///< triangles of a leaf, else 0
    [[nodiscard]] Bounds bounds() const noexcept {
      return {{low[0], low[1], low[2]}, {high[0], high[1], high[2]}};
    }
  };
  /// A lower bound of the distance from a convex set, and its derivative along a motion.
  struct Approach {
    double distance, slope;
  };
  /// A flat cylinder around the triangles of a node. It encloses a smooth surface at an angle much
  /// more closely than the box, so that fewer nodes are near a sphere that touches the surface.
  /// Single precision, rounded outwards.
  struct Plate {
    std::array<float, 3> centre{}, axis{};
    float half_thickness = 0, radius = 0;
    [[nodiscard]] Approach approach(const Vec3& p, const Vec3& motion,
                                    double length) const noexcept;
  };
  static constexpr int kMaxDepth = 62; ///< depth of the hierarchy; halving 2^32 triangles needs 32
  static constexpr int kNodeWork = 5, kTriangleWork = 4, kStepWork = 4;
  struct Corners {
    Vec3 a, b, c;
  };
  [[nodiscard]] Corners corners_of(std::size_t triangle) const noexcept {
    const Triangle& t = triangles_[triangle];
    return {corners_[t[0]], corners_[t[1]], corners_[t[2]]};
  }
  template <class Visit>
  void traverse(const Vec3& from, const Vec3& to, double radius, const double& limit,
                WorkLimit& work, const Visit& visit) const noexcept;
  void weld(std::span<const Vec3> corners, std::span<const Triangle> triangles);
  void build(std::size_t node, std::span<std::uint32_t> order, std::span<const Vec3> centroids,
             std::uint32_t first, int depth);
  void sort(std::span<const std::uint32_t> order);
  [[nodiscard]] Plate plate_around(std::span<const std::uint32_t> order) const;

  std::vector<Vec3> corners_;
  std::vector<Triangle> triangles_;
  std::vector<Node> nodes_;
  std::vector<Plate> plates_; ///< plate of each node
  Bounds bounds_{};
};

} // namespace tactus::haptic
