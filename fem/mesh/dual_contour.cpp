#include "fem/mesh/dual_contour.hpp"

#include "fem/small_dense.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

namespace tactus::fem {
namespace {

/// Corner c of a cell lies at (c & 1, c >> 1 & 1, c >> 2); edge e runs along axis e / 4, from the
/// corner whose bits of the other two axes are those of e % 4.
struct CellEdge {
  int from, to, axis;
};
constexpr std::array<CellEdge, 12> kEdges = [] {
  std::array<CellEdge, 12> edges{};
  for (int e = 0; e < 12; ++e) {
    const int axis = e / 4, u = (axis + 1) % 3, v = (axis + 2) % 3;
    const int from = (e % 4 & 1) << u | (e % 4 >> 1) << v;
    edges[static_cast<std::size_t>(e)] = {from, from | 1 << axis, axis};
  }
  return edges;
}();

int edge_between(int a, int b) {
  for (int e = 0; e < 12; ++e)
    if ((kEdges[at(e)].from == a && kEdges[at(e)].to == b) ||
        (kEdges[at(e)].from == b && kEdges[at(e)].to == a))
      return e;
  return -1;
}

/// For each of a cell's edges, the sheet of surface to which it belongs, or -1. On a face with two
/// diagonally opposite inside corners, each of these corners is cut off separately, so that both
/// cells of the face agree.
std::array<int, 12> sheets_of(int corners) {
  std::array<int, 12> sheet{};
  std::iota(sheet.begin(), sheet.end(), 0);
  const auto root = [&](int e) {
    while (sheet[at(e)] != e)
      e = sheet[at(e)];
    return e;
  };
  const auto is_in = [&](int c) { return (corners >> c & 1) != 0; };
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      const int u = 1 << (axis + 1) % 3, v = 1 << (axis + 2) % 3, base = side << axis;
      const std::array<int, 4> ring{base, base | u, base | u | v, base | v};
      std::vector<int> cut;
      for (std::size_t i = 0; i < 4; ++i)
        if (is_in(ring[i]) != is_in(ring[(i + 1) % 4]))
          cut.push_back(edge_between(ring[i], ring[(i + 1) % 4]));
      if (cut.size() == 2)
        sheet[at(root(cut[0]))] = root(cut[1]);
      if (cut.size() == 4)
        for (std::size_t i = 0; i < 4; ++i)
          if (is_in(ring[i]))
            sheet[at(root(edge_between(ring[(i + 3) % 4], ring[i])))] =
                root(edge_between(ring[i], ring[(i + 1) % 4]));
    }
  std::array<int, 12> result{};
  for (int e = 0; e < 12; ++e) {
    const CellEdge& edge = kEdges[at(e)];
    result[at(e)] = is_in(edge.from) == is_in(edge.to) ? -1 : root(e);
  }
  return result;
}

struct Cut {
  Vec3 position, normal; ///< a zero normal means that no plane is known here
};

/// Where the surface cuts a grid edge: the crossing nearest to the outside end, at which the
/// winding number falls to zero.
Cut cut_of(const RayGrid& grid, const std::vector<std::uint8_t>& inside,
           const std::array<int, 3>& from, int axis) {
  const bool starts_inside = inside[grid.index(from[0], from[1], from[2])] != 0;
  const auto hits = grid.between(from, axis);
  const auto leaves = [&](const Crossing& c) { return (c.sign > 0) == starts_inside; };
  const Crossing* chosen = nullptr;
  for (std::size_t i = 0; i < hits.size(); ++i) { // selects the crossing nearest to the outside end
    const Crossing& c = starts_inside ? hits[hits.size() - 1 - i] : hits[i];
    if (leaves(c)) {
      chosen = &c;
      break;
    }
  }
  if (!chosen && !hits.empty())
    chosen = starts_inside ? &hits.back() : &hits.front();
  Vec3 p = grid.point(from);
  if (!chosen) {
    p[axis] += .5 * grid.spacing();
    return {p, {}};
  }
  p[axis] = chosen->position;
  return {p, chosen->normal};
}

/// The point nearest to all planes of the cuts; in directions that the planes leave free, nearest
/// to the cuts' mean.
Vec3 meeting_point(const std::vector<Cut>& cuts, const Vec3& low, double spacing) {
  Vec3 mean;
  for (const Cut& c : cuts)
    mean += (1. / static_cast<double>(cuts.size())) * c.position;
  std::array<Vec3, 3> squares; // sum of n n'
  Vec3 right;
  for (const Cut& c : cuts) {
    for (int i = 0; i < 3; ++i)
      squares[at(i)] += c.normal[i] * c.normal;
    right += dot(c.normal, c.position - mean) * c.normal;
  }
  const auto [values, vectors] = symmetric_eigenpairs(squares);
  const double limit = .08 * values[2];
  Vec3 p = mean;
  for (std::size_t k = 0; k < 3; ++k)
    if (values[k] > std::max(limit, 1e-12))
      p += dot(vectors[k], right) / values[k] * vectors[k];
  for (int k = 0; k < 3; ++k)
    p[k] = std::clamp(p[k], low[k] + .02 * spacing, low[k] + .98 * spacing);
  return p;
}

/// Adds a point for each sheet of the surface in a cell. Returns each edge's point, -1 if it has
/// none.
std::array<int, 12> add_points(Triangles& out, const RayGrid& grid,
                               const std::vector<std::uint8_t>& inside, bool sharp,
                               const std::array<int, 3>& cell, const std::array<int, 12>& sheet) {
  std::array<int, 12> points{};
  points.fill(-1);
  for (int s = 0; s < 12; ++s) {
    if (sheet[at(s)] != s)
      continue;
    std::vector<Cut> cuts;
    for (int e = 0; e < 12; ++e)
      if (sheet[at(e)] == s) {
        const CellEdge& edge = kEdges[at(e)];
        cuts.push_back(cut_of(
            grid, inside,
            {cell[0] + (edge.from & 1), cell[1] + (edge.from >> 1 & 1), cell[2] + (edge.from >> 2)},
            edge.axis));
        if (!sharp)
          cuts.back().normal = {};
        points[at(e)] = static_cast<int>(out.points.size());
      }
    out.points.push_back(meeting_point(cuts, grid.point(cell), grid.spacing()));
  }
  return points;
}

/// Adds a quadrangle as two triangles, cut along the diagonal with the smaller bend.
void add_quadrangle(Triangles& out, const std::array<int, 4>& quad) {
  const auto p = [&](std::size_t n) { return out.points[at(quad[n])]; };
  const auto bend = [&](std::size_t a) { // bend between the halves at the diagonal from a
    const Vec3 n = cross(p((a + 1) % 4) - p(a), p((a + 2) % 4) - p(a)),
               m = cross(p((a + 2) % 4) - p(a), p((a + 3) % 4) - p(a));
    return dot(n, m) / std::max(length(n) * length(m), 1e-300);
  };
  const std::size_t a = bend(0) >= bend(1) ? 0 : 1;
  out.triangles.push_back({quad[a], quad[a + 1], quad[a + 2]});
  out.triangles.push_back({quad[a], quad[a + 2], quad[(a + 3) % 4]});
}

} // namespace

Triangles dual_contour(const RayGrid& grid, const std::vector<std::uint8_t>& inside, bool sharp) {
  Triangles out;
  const auto& size = grid.size();
  static const std::array<std::array<int, 12>, 256> sheets = [] {
    std::array<std::array<int, 12>, 256> all{};
    for (int c = 0; c < 256; ++c)
      all[at(c)] = sheets_of(c);
    return all;
  }();
  const auto corners_of = [&](int i, int j, int k) {
    int corners = 0;
    const std::size_t first = grid.index(i, j, k);
    for (int c = 0; c < 8; ++c)
      if (inside[first + (c & 1 ? 1 : 0) + (c >> 1 & 1 ? grid.step(1) : 0) +
                 (c >> 2 ? grid.step(2) : 0)] != 0)
        corners |= 1 << c;
    return corners;
  };
  std::unordered_map<std::size_t, std::array<int, 12>> points_of; // points of a cell, by edge
  for (int k = 0; k + 1 < size[2]; ++k)
    for (int j = 0; j + 1 < size[1]; ++j)
      for (int i = 0; i + 1 < size[0]; ++i) {
        const int corners = corners_of(i, j, k);
        if (corners == 0 || corners == 255)
          continue;
        points_of[grid.index(i, j, k)] =
            add_points(out, grid, inside, sharp, {i, j, k}, sheets[at(corners)]);
      }
  // The four cells around each grid edge from inside to outside give a quadrangle.
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (int k = 0; k < size[2]; ++k)
      for (int j = 0; j < size[1]; ++j)
        for (int i = 0; i < size[0]; ++i) {
          const std::array<int, 3> c{i, j, k};
          if (c[at(axis)] + 1 >= size[at(axis)] || c[at(u)] == 0 || c[at(v)] == 0)
            continue;
          const std::size_t here = grid.index(i, j, k);
          const bool starts_inside = inside[here] != 0;
          if (starts_inside == (inside[here + grid.step(axis)] != 0))
            continue;
          std::array<int, 4> quad{};
          static constexpr std::array<std::array<int, 2>, 4> ring{{{0, 0}, {1, 0}, {1, 1}, {0, 1}}};
          for (std::size_t n = 0; n < 4; ++n) { // offset of the cell below the edge
            const auto [back_u, back_v] = ring[n];
            const std::size_t cell = here - at(back_u) * grid.step(u) - at(back_v) * grid.step(v);
            quad[n] = points_of.at(cell)[at(4 * axis + (back_u | back_v << 1))];
          }
          // In this order, first u and then v falling, the cells turn to the left about the axis.
          if (!starts_inside)
            std::swap(quad[1], quad[3]);
          add_quadrangle(out, quad);
        }
  }
  return out;
}

} // namespace tactus::fem
