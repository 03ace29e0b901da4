#pragma once
#include "fem/io/triangles.hpp"

#include <cstdint>

namespace tactus::fem {

/// Where a grid line meets a triangle: the coordinate along the line, and +1 where the line leaves
/// the surface, -1 where it enters.
struct Crossing {
  double position;
  int sign;
  Vec3 normal; ///< of unit length
};

/// A regular grid of points around a surface, and every crossing of its lines with the triangles.
class RayGrid {
public:
  /// The points are `spacing` (m) apart, with `margin` points beyond the surface's box on every
  /// side. Their origin is shifted by odd shares of the spacing, so that faces parallel to an axis
  /// do not lie on grid lines.
  RayGrid(const Triangles&, double spacing, int margin);

  [[nodiscard]] double spacing() const noexcept { return spacing_; }
  [[nodiscard]] const std::array<int, 3>& size() const noexcept { return size_; }
  [[nodiscard]] std::size_t count() const noexcept;
  [[nodiscard]] std::size_t index(int i, int j, int k) const noexcept;
  [[nodiscard]] std::array<int, 3> cell(std::size_t index) const noexcept;
  [[nodiscard]] Vec3 point(const std::array<int, 3>&) const noexcept;
  /// The difference in index() to the next point along an axis.
  [[nodiscard]] std::size_t step(int axis) const noexcept;

  /// Crossings between a point and the next one along an axis, ascending.
  [[nodiscard]] std::span<const Crossing> between(const std::array<int, 3>&, int axis) const;

  /// The winding number of the surface at every point, along x.
  [[nodiscard]] std::vector<std::int8_t> winding() const;
  /// The volumes with winding numbers above zero and below zero, m^3. They follow from the inside
  /// lengths of lines along the axis to which most faces are perpendicular; for a plate, through
  /// its thickness. Each line has a random position in its square, since lines on a regular grid
  /// would hit or miss whole rows of a face that is aligned with the grid.
  [[nodiscard]] std::array<double, 2> volumes(const Triangles&) const;

private:
  struct Line {
    std::size_t first, last;
  };
  struct Lines {
    std::vector<Line> of;
    std::vector<Crossing> crossings;
  };
  [[nodiscard]] Lines cross_lines(const Triangles&, int axis, double jitter) const;
  [[nodiscard]] std::size_t line_of(const std::array<int, 3>&, int axis) const noexcept;

  double spacing_;
  Vec3 origin_;
  std::array<int, 3> size_{};
  std::array<Lines, 3> lines_;
};

} // namespace tactus::fem
