#include "fem/mesh/resurface.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/dual_contour.hpp"
#include "fem/mesh/shells.hpp"
#include "fem/mesh/weld.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

constexpr double kMaxGridPoints = 4e7;  ///< limits the grid's memory
constexpr double kMaxSheets = .2;       ///< largest fraction of a wrap's triangles that enclose
                                        ///< nothing
constexpr double kMaxSkinSquares = 3e5; ///< largest skin area, in units of the squared grid spacing

/// m^2.
double skin_area(const Triangles& t) {
  double sum = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    sum += .5 * length(t.normal(i));
  return sum;
}

/// The target spacing, or the finest spacing within the limits if that is coarser, m.
double affordable(const Triangles& t, double target_spacing) {
  const Vec3 size = bounding_box(t.points).size();
  const double grid_volume = (size.x + 20 * target_spacing) * (size.y + 20 * target_spacing) *
                             (size.z + 20 * target_spacing);
  return std::max({target_spacing, std::cbrt(grid_volume / kMaxGridPoints),
                   std::sqrt(skin_area(t) / kMaxSkinSquares)});
}

/// Squared distance of every grid point to the nearest marked one, in squares of the spacing;
/// (limit + 1)^2 if none is within `limit` spacings. Computed for one axis after the other, as in
/// Felzenszwalb & Huttenlocher 2012, but only points within `limit` of each other are compared.
std::vector<float> squared_distance(const RayGrid& grid, const std::vector<std::uint8_t>& marked,
                                    int limit) {
  const float far = static_cast<float>(limit + 1) * static_cast<float>(limit + 1);
  std::vector<float> square(marked.size());
  for (std::size_t i = 0; i < marked.size(); ++i)
    square[i] = marked[i] ? 0.F : far;
  for (int axis = 0; axis < 3; ++axis) {
    const auto n = static_cast<std::size_t>(grid.size()[static_cast<std::size_t>(axis)]);
    const std::size_t step = grid.step(axis);
    std::vector<float> line(n);
    for (std::size_t start = 0; start < square.size(); ++start) {
      if (grid.cell(start)[static_cast<std::size_t>(axis)] != 0)
        continue;
      bool any = false;
      for (std::size_t i = 0; i < n; ++i) {
        line[i] = square[start + i * step];
        any = any || line[i] < far;
      }
      if (!any)
        continue;
      for (std::size_t i = 0; i < n; ++i) {
        float best = line[i];
        for (int d = 1; d <= limit && static_cast<float>(d * d) < best; ++d) {
          const auto offset = static_cast<std::size_t>(d);
          const auto more = static_cast<float>(d * d);
          if (i >= offset)
            best = std::min(best, line[i - offset] + more);
          if (i + offset < n)
            best = std::min(best, line[i + offset] + more);
        }
        square[start + i * step] = best;
      }
    }
  }
  return square;
}

/// Calls use(neighbour, crossed) for the up to six grid points next to one. crossed: a triangle
/// lies between the two.
template <class Use> void for_each_neighbour(const RayGrid& grid, std::size_t index, Use&& use) {
  const auto cell = grid.cell(index);
  for (int axis = 0; axis < 3; ++axis) {
    const auto a = static_cast<std::size_t>(axis);
    if (cell[a] > 0) {
      auto before = cell;
      --before[a];
      use(index - grid.step(axis), !grid.between(before, axis).empty());
    }
    if (cell[a] + 1 < grid.size()[a])
      use(index + grid.step(axis), !grid.between(cell, axis).empty());
  }
}

/// The volume between the outer shells and their cavities, m^3.
double enclosed(const Triangles& t) {
  // Each shell is oriented outward; separate_bodies() turns the shells that are cavities.
  double sum = 0;
  for (const Triangles& body : separate_bodies(t))
    for (std::size_t i = 0; i < body.triangles.size(); ++i)
      sum += dot(body.corner(i, 0), cross(body.corner(i, 1), body.corner(i, 2))) / 6;
  return sum;
}

/// Smooths a surface over a few grid spacings while keeping its volume: each pass moves every point
/// by a fraction of its distance to the mean of its neighbours, alternately towards the mean and
/// away from it (Taubin 1995).
void smooth(Triangles& t) {
  std::vector<Vec3> sum(t.points.size());
  std::vector<double> count(t.points.size());
  for (int pass = 0; pass < 100; ++pass) {
    const double share = pass % 2 == 0 ? .5 : -.53;
    std::fill(sum.begin(), sum.end(), Vec3{});
    std::fill(count.begin(), count.end(), 0.);
    for (const auto& c : t.triangles)
      for (std::size_t k = 0; k < 3; ++k) {
        sum[static_cast<std::size_t>(c[k])] += t.points[static_cast<std::size_t>(c[(k + 1) % 3])];
        ++count[static_cast<std::size_t>(c[k])];
      }
    for (std::size_t i = 0; i < t.points.size(); ++i)
      if (count[i] > 0)
        t.points[i] += share * ((1 / count[i]) * sum[i] - t.points[i]);
  }
}

/// Moves touching sheets apart, so that elements fit between them. weld() gave each sheet a copy of
/// a common point, and one of the sheets a point in the middle of a common edge. These points move
/// a tenth of the distance towards their neighbours.
void part_touching(Triangles& t, double distance) {
  std::vector<std::vector<int>> ring(t.points.size());
  for (const auto& c : t.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      ring[static_cast<std::size_t>(c[k])].push_back(c[(k + 1) % 3]);
  const auto at = [&](int v) -> const Vec3& { return t.points[static_cast<std::size_t>(v)]; };
  std::vector<bool> touches(t.points.size(), false);
  const std::vector<int> first = coincident_points(t.points, distance);
  for (std::size_t v = 0; v < first.size(); ++v) {
    if (first[v] != static_cast<int>(v))
      touches[v] = touches[static_cast<std::size_t>(first[v])] = true;
    if (ring[v].size() == 4)
      for (std::size_t a = 0; a < 4; ++a)
        for (std::size_t b = 0; b < a; ++b)
          if (length(.5 * (at(ring[v][a]) + at(ring[v][b])) - t.points[v]) < 1e-6 * distance)
            touches[v] = true;
  }
  std::vector<Vec3> moved = t.points;
  for (std::size_t v = 0; v < touches.size(); ++v)
    if (touches[v])
      for (const int w : ring[v])
        moved[v] += (.1 / static_cast<double>(ring[v].size())) * (at(w) - t.points[v]);
  t.points = std::move(moved);
}

/// Removes crossings of triangles, which appear if more than one sheet passes through a cell. In up
/// to ten passes, the points of crossing triangles move half of the distance towards the mean of
/// their neighbours.
void relax_crossings(Triangles& t) {
  for (int pass = 0; pass < 10; ++pass) {
    const auto pairs = crossings(t, 10000);
    if (pairs.empty())
      return;
    std::vector<Vec3> sum(t.points.size());
    std::vector<int> count(t.points.size(), 0);
    std::vector<bool> moves(t.points.size(), false);
    for (const auto& pair : pairs)
      for (const std::size_t i : pair)
        for (const int v : t.triangles[i])
          moves[static_cast<std::size_t>(v)] = true;
    for (const auto& c : t.triangles)
      for (std::size_t k = 0; k < 3; ++k)
        if (const auto v = static_cast<std::size_t>(c[k]); moves[v]) {
          sum[v] += t.points[static_cast<std::size_t>(c[(k + 1) % 3])];
          ++count[v];
        }
    for (std::size_t v = 0; v < moves.size(); ++v)
      if (count[v] > 0)
        t.points[v] += .5 * ((1. / count[v]) * sum[v] - t.points[v]);
  }
}

Resurfaced contoured(const RayGrid& grid, const std::vector<std::uint8_t>& inside, bool sharp) {
  Resurfaced out;
  out.spacing = grid.spacing();
  out.surface = dual_contour(grid, inside, sharp);
  if (out.surface.triangles.empty())
    throw InputError("the triangles enclose nothing");
  weld(out.surface);
  if (!sharp)
    smooth(out.surface);
  part_touching(out.surface, .01 * grid.spacing());
  relax_crossings(out.surface);
  close(out.surface);
  return out;
}

} // namespace

Resurfaced united(const Triangles& t, double finer) {
  const double skin = skin_area(t);
  double whole = 0;
  for (const double v : shell_volumes(t))
    whole += std::abs(v);
  const double wall = 2 * whole / skin, largest = bounding_box(t.points).largest();
  const double spacing = affordable(t, std::min(largest / 60, .4 * wall) / finer);
  const RayGrid grid(t, spacing, 2);
  const auto winding = grid.winding();
  std::vector<std::uint8_t> inside(winding.size());
  for (std::size_t i = 0; i < winding.size(); ++i)
    inside[i] = winding[i] > 0;
  Resurfaced out = contoured(grid, inside, true);
  const auto [volume, inverted] = grid.volumes(t);
  out.volume = volume;
  out.inverted = inverted;
  out.volume_change = enclosed(out.surface) / volume - 1;
  return out;
}

namespace {

/// Marks the grid points that the centre of a ball reaches from the border of the grid without
/// meeting a triangle. to_triangle: squared distance of each point to the triangles, in units of
/// the squared spacing, like the ball's squared_radius.
std::vector<std::uint8_t> ball_centres(const RayGrid& grid, const std::vector<float>& to_triangle,
                                       float squared_radius) {
  std::vector<std::uint8_t> centre(grid.count(), 0);
  std::vector<std::size_t> front{0};
  centre[0] = 1;
  while (!front.empty()) {
    const std::size_t i = front.back();
    front.pop_back();
    for_each_neighbour(grid, i, [&](std::size_t j, bool) {
      if (!centre[j] && to_triangle[j] >= squared_radius) {
        centre[j] = 1;
        front.push_back(j);
      }
    });
  }
  return centre;
}

/// Among the triangles between two grid points, the fraction with both points outside. The ball
/// touches these triangles from both sides.
double share_of_sheets(const RayGrid& grid, const std::vector<std::uint8_t>& inside) {
  std::size_t all = 0, sheets = 0;
  for (std::size_t i = 0; i < inside.size(); ++i)
    for_each_neighbour(grid, i, [&](std::size_t j, bool crossed) {
      all += crossed;
      sheets += crossed && !inside[i] && !inside[j];
    });
  return all > 0 ? static_cast<double>(sheets) / static_cast<double>(all) : 1;
}

} // namespace

Resurfaced shrink_wrapped(const Triangles& t, double gap) {
  const double largest = bounding_box(t.points).largest();
  const double spacing = affordable(t, std::min(gap / 4, largest / 80));
  constexpr double kMinRadius = 1.5, kMaxRadius = 60;
  const double radius = .5 * gap / spacing; // radius of the ball, in spacings
  if (radius < kMinRadius)
    throw InputError(format("--shrink-wrap %.3g mm is too fine for this surface: expected at least "
                            "%.3g mm",
                            1e3 * gap, 1e3 * 2 * kMinRadius * spacing));
  if (radius > kMaxRadius)
    throw InputError(format("--shrink-wrap %.3g mm is too wide for a body of %.3g mm: expected "
                            "at most %.3g mm",
                            1e3 * gap, 1e3 * largest, 1e3 * 2 * kMaxRadius * spacing));
  const int margin = static_cast<int>(std::ceil(radius)) + 3;
  const RayGrid grid(t, spacing, margin);
  std::vector<std::uint8_t> marked(grid.count(), 0); // grid points next to a triangle
  for (std::size_t i = 0; i < marked.size(); ++i)
    for_each_neighbour(grid, i, [&](std::size_t, bool crossed) { marked[i] |= crossed; });
  const auto to_triangle = squared_distance(grid, marked, static_cast<int>(std::ceil(radius)));
  const auto squared_radius = static_cast<float>(radius * radius);
  const std::vector<std::uint8_t> centre = ball_centres(grid, to_triangle, squared_radius);
  // The region covered by the ball is outside. Then points of the front, up to 2 spacings behind
  // it, also become outside if more of their outside neighbours are connected to them freely than
  // through a triangle. The skin then reaches the triangles, and a crack between them stays closed.
  const double cover = radius + 2;
  const auto to_centre = squared_distance(grid, centre, static_cast<int>(std::ceil(cover)));
  std::vector<std::uint8_t> inside(grid.count());
  std::vector<std::size_t> front;
  for (std::size_t i = 0; i < inside.size(); ++i) {
    inside[i] = to_centre[i] >= squared_radius;
    if (inside[i] && to_centre[i] <= static_cast<float>(cover * cover))
      front.push_back(i);
  }
  for (int pass = 0; pass < 3; ++pass) {
    std::vector<std::size_t> outside;
    for (const std::size_t i : front) {
      int votes = 0;
      for_each_neighbour(grid, i, [&](std::size_t j, bool crossed) {
        if (!inside[j])
          votes += crossed ? -1 : 1;
      });
      if (inside[i] && votes > 0)
        outside.push_back(i);
    }
    for (const std::size_t i : outside)
      inside[i] = 0;
  }
  if (share_of_sheets(grid, inside) > kMaxSheets)
    throw EnclosesNothing(
        format("--shrink-wrap %.3g mm: the triangles enclose nothing at that gap: expected more "
               "than their widest hole",
               1e3 * gap));
  Resurfaced out = contoured(grid, inside, false);
  out.volume = enclosed(out.surface);
  return out;
}

} // namespace tactus::fem
