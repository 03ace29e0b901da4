#pragma once
#include "fem/mesh/mesh.hpp"
#include "fem/shapes/grid.hpp"

#include <array>

#include <functional>

namespace tactus::fem {

/// A point of a body of revolution's half section: distance from the axis, height. Metres.
struct Meridian {
  double r = 0, z = 0;
};

/// A half section in quadratic quadrilaterals: corners counter-clockwise in (r, z), then the
/// mid-edge nodes that follow each corner.
struct Section {
  std::vector<std::array<Meridian, 8>> quads;
  std::vector<std::array<int, 2>> interval; ///< of each quad along its first and second side
  SweepGrid grid;                           ///< grid without the direction around the axis

  /// Adds the image of the unit square, divided at the given coordinates. The map must preserve the
  /// orientation. `number(i, j)` returns the grid's intervals that a cell spans along u and v.
  void add_mapped(std::span<const double> us, std::span<const double> vs,
                  const std::function<Meridian(double u, double v)>& map,
                  const std::function<std::array<int, 2>(int i, int j)>& number);
};

/// Ends of a line at concave edges, where the stress grows without bound.
struct Ends {
  bool low = false, high = false;
};
/// The division of a line from a to b into intervals about `h` long. Towards a concave end the
/// intervals shrink geometrically, by `ratio` per step, down to `smallest`.
struct Division {
  double a, b, h;
  int min_divisions; ///< applies without concave ends
  Ends concave{};
  double smallest = 0, ratio = 2;
};
/// The coordinates of the ends of all intervals, from a to b.
[[nodiscard]] std::vector<double> divide(const Division&);
/// The number of intervals that `divide` makes. It needs almost no memory, however small `h` is.
[[nodiscard]] double count_divisions(const Division&);

/// Counts of the parts of a section's mesh. Corners and edges on the axis are counted separately,
/// since revolving does not multiply them.
struct SectionSize {
  double quads = 0, corners = 0, sides = 0;
  double outer_sides = 0;                                  ///< on the body's skin
  double axis_quads = 0, axis_corners = 0, axis_sides = 0; ///< the part of these on the axis
};

/// Rectangles between breaks in r and z where `solid(i, j)` is true. Lines through concave corners,
/// where three of four neighbours are solid, are graded, because stress grows without bound there
/// and a uniform mesh converges only at first order.
struct Rectangles {
  std::vector<double> r, z;
  std::vector<std::vector<bool>> solid; ///< [i][j]: between r[i], r[i+1] and z[j], z[j+1]
  std::vector<std::size_t> singular_r{},
      singular_z{}; ///< further breaks to grade towards, at edges of supports
  double h = 0;
  int min_divisions_r = 2, min_divisions_z = 2;
  bool grade = true;
  double grading = 27; ///< ratio of the other intervals to the smallest
};
/// `grid`: lines to use instead of those that follow from h.
[[nodiscard]] Section rectangles(const Rectangles&, const SweepGrid* grid = nullptr);
[[nodiscard]] SectionSize size_of(const Rectangles&, const SweepGrid* grid = nullptr);

/// A shell along a meridian curve: u from 0 to 1, thickness across the curve's normal.
struct Shell {
  std::function<Meridian(double)> middle;
  std::function<double(double)> thickness;
  int along = 24, layers = 1;
};
[[nodiscard]] Section shell(const Shell&, const SweepGrid* grid = nullptr);
/// The size of a shell section of `along` by `layers` quads. on_axis: the ends that lie on the
/// axis.
[[nodiscard]] SectionSize size_of_shell(double along, double layers, Ends on_axis);

/// Turns a section about the z axis: hex20 away from the axis, wedge15 along it. Nodes lie exactly
/// on the body of revolution. Refuses a section that touches the axis only with a corner.
[[nodiscard]] Mesh revolve(const Section&, int sectors);

} // namespace tactus::fem
