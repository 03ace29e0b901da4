#include "fem/mesh/mesh.hpp"

#include "fem/element/jacobian.hpp"
#include "fem/element/quadrature.hpp"
#include "fem/io/text.hpp"

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstdio>
#include <limits>
#include <numeric>
#include <unordered_map>

namespace tactus::fem {

void Mesh::add(Shape shape, std::span<const int> element_nodes, int region) {
  elements.push_back({shape, region, connectivity.size()});
  connectivity.insert(connectivity.end(), element_nodes.begin(), element_nodes.end());
}

std::string Mesh::element_names() const {
  std::array<bool, kShapes> present{};
  for (const Element& e : elements)
    present[static_cast<std::size_t>(e.shape)] = true;
  std::string names;
  for (std::size_t i = 0; i < present.size(); ++i)
    if (present[i])
      names += (names.empty() ? "" : " + ") + std::string(name(static_cast<Shape>(i)));
  return names;
}

double Box::largest() const noexcept {
  const Vec3 s = size();
  return std::max({s.x, s.y, s.z});
}

Box bounding_box(std::span<const Vec3> points) {
  if (points.empty())
    return {};
  Box box{points[0], points[0]};
  for (const Vec3& p : points)
    for (int k = 0; k < 3; ++k) {
      box.low[k] = std::min(box.low[k], p[k]);
      box.high[k] = std::max(box.high[k], p[k]);
    }
  return box;
}

double volume(const Mesh& mesh) {
  double total = 0;
  ShapeValues values;
  for (const Element& e : mesh.elements)
    for (const QuadraturePoint& q : mass_points(e.shape)) {
      evaluate(e.shape, q.at, values);
      total += q.weight * jacobian(mesh, e, values).determinant;
    }
  return total;
}

Parts connected_parts(const Mesh& mesh) {
  std::vector<int> parent(mesh.nodes.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[static_cast<std::size_t>(i)] != i) {
      int& up = parent[static_cast<std::size_t>(i)];
      up = parent[static_cast<std::size_t>(up)];
      i = up;
    }
    return i;
  };
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    for (const int n : nodes.subspan(1)) {
      const int a = root(nodes[0]), b = root(n);
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
    }
  }
  Parts parts{std::vector<int>(mesh.nodes.size(), -1), 0};
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    int& of_root = parts.of_node[static_cast<std::size_t>(root(static_cast<int>(i)))];
    if (of_root < 0)
      of_root = parts.count++;
    parts.of_node[i] = of_root;
  }
  return parts;
}

namespace {

/// Renumbers all nodes and keeps their order; -1 in `to` removes a node.
void renumber(Mesh& mesh, std::span<const int> to, std::size_t remaining) {
  std::vector<Vec3> kept(remaining);
  for (std::size_t i = mesh.nodes.size(); i-- > 0;)
    if (to[i] >= 0)
      kept[static_cast<std::size_t>(to[i])] = mesh.nodes[i];
  mesh.nodes = std::move(kept);
  for (int& n : mesh.connectivity)
    n = to[static_cast<std::size_t>(n)];
  for (auto& [name, set] : mesh.node_sets) {
    for (int& n : set)
      n = to[static_cast<std::size_t>(n)];
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
    if (!set.empty() && set.front() < 0)
      set.erase(set.begin());
  }
}

} // namespace

void drop_unused_nodes(Mesh& mesh) {
  std::vector<int> to(mesh.nodes.size(), -1);
  for (const int n : mesh.connectivity)
    to[static_cast<std::size_t>(n)] = 0;
  int count = 0;
  for (int& n : to)
    if (n == 0)
      n = count++;
  if (static_cast<std::size_t>(count) != mesh.nodes.size())
    renumber(mesh, to, static_cast<std::size_t>(count));
}

std::vector<int> coincident_points(std::span<const Vec3> points, double tolerance) {
  // Cells four tolerances wide; a point's partner lies in its own or a neighbouring cell.
  const Box box = bounding_box(points);
  const double cell = 4 * tolerance;
  const auto key = [](std::int64_t i, std::int64_t j, std::int64_t k) {
    return static_cast<std::uint64_t>(i) * 0x9E3779B97F4A7C15ULL ^
           static_cast<std::uint64_t>(j) * 0xC2B2AE3D27D4EB4FULL ^
           static_cast<std::uint64_t>(k) * 0x165667B19E3779F9ULL;
  };
  std::unordered_multimap<std::uint64_t, int> cells;
  cells.reserve(points.size());
  std::vector<int> to(points.size());
  for (std::size_t n = 0; n < points.size(); ++n) {
    const Vec3& p = points[n];
    std::array<std::int64_t, 3> at{}, low{}, high{};
    for (int k = 0; k < 3; ++k) {
      const double coordinate = (p[k] - box.low[k]) / cell;
      const auto i = static_cast<std::size_t>(k);
      at[i] = static_cast<std::int64_t>(coordinate);
      low[i] = static_cast<std::int64_t>(std::floor(coordinate - .25));
      high[i] = static_cast<std::int64_t>(std::floor(coordinate + .25));
    }
    int partner = -1;
    for (auto i = low[0]; i <= high[0]; ++i)
      for (auto j = low[1]; j <= high[1]; ++j)
        for (auto k = low[2]; k <= high[2]; ++k) {
          const auto [first, last] = cells.equal_range(key(i, j, k));
          for (auto c = first; c != last; ++c)
            if (length(points[static_cast<std::size_t>(c->second)] - p) <= tolerance)
              partner = c->second;
        }
    if (partner < 0) {
      partner = static_cast<int>(n);
      cells.emplace(key(at[0], at[1], at[2]), partner);
    }
    to[n] = partner;
  }
  return to;
}

std::size_t merge_nodes(Mesh& mesh, double tolerance) {
  std::vector<int> to = coincident_points(mesh.nodes, tolerance);
  int count = 0;
  for (std::size_t n = 0; n < to.size(); ++n)
    to[n] = to[n] == static_cast<int>(n) ? count++ : to[static_cast<std::size_t>(to[n])];
  const std::size_t before = mesh.nodes.size();
  if (static_cast<std::size_t>(count) != before)
    renumber(mesh, to, static_cast<std::size_t>(count));
  return before - static_cast<std::size_t>(count);
}

double min_jacobian(const Mesh& mesh, const Element& e) {
  ShapeValues values;
  double min_determinant = std::numeric_limits<double>::infinity();
  const auto sample = [&](const Vec3& at) {
    evaluate(e.shape, at, values);
    min_determinant = std::min(min_determinant, jacobian(mesh, e, values).determinant);
  };
  for (const QuadraturePoint& q : mass_points(e.shape))
    sample(q.at);
  for (const QuadraturePoint& q : stiffness_points(e.shape))
    sample(q.at);
  return min_determinant;
}

namespace {

/// Calls `visit(a, b, middle)` with the nodes of each side of a tet10.
template <class Visit> void visit_sides(const Mesh& mesh, const Element& e, Visit&& visit) {
  constexpr std::array<std::array<std::size_t, 2>, 6> kEnds{
      {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}}};
  const auto nodes = mesh.nodes_of(e);
  for (std::size_t s = 0; s < kEnds.size(); ++s)
    visit(static_cast<std::size_t>(nodes[kEnds[s][0]]),
          static_cast<std::size_t>(nodes[kEnds[s][1]]), static_cast<std::size_t>(nodes[4 + s]));
}

/// Vector from the middle of an edge to its mid-edge node.
Vec3 bend(const Mesh& mesh, std::size_t a, std::size_t b, std::size_t middle) {
  return mesh.nodes[middle] - .5 * (mesh.nodes[a] + mesh.nodes[b]);
}

} // namespace

bool has_straight_sides(const Mesh& mesh) {
  bool straight = true;
  for (const Element& e : mesh.elements)
    if (e.shape == Shape::tet10)
      visit_sides(mesh, e, [&](std::size_t a, std::size_t b, std::size_t middle) {
        straight = straight &&
                   length(bend(mesh, a, b, middle)) <= 1e-6 * length(mesh.nodes[b] - mesh.nodes[a]);
      });
  return straight;
}

std::size_t straighten_inverted(Mesh& mesh) {
  // The bend is halved at most twice, so that most edges keep at least a quarter of it; the next
  // attempt makes the edge straight. A nearly flat element would be far too stiff, as an inverted
  // one is far too soft.
  constexpr double kMinJacobianShare = .05; ///< relative to the Jacobian with straight sides
  constexpr int kHalvings = 3;
  std::vector<std::uint8_t> halvings(mesh.nodes.size(), 0);
  std::vector<std::size_t> straightened, candidates(mesh.elements.size());
  std::vector<std::vector<std::size_t>> around(mesh.nodes.size());
  for (std::size_t i = 0; i < mesh.elements.size(); ++i) {
    candidates[i] = i;
    if (mesh.elements[i].shape == Shape::tet10)
      for (const int n : mesh.nodes_of(mesh.elements[i]).subspan(4))
        around[static_cast<std::size_t>(n)].push_back(i);
  }
  const auto straight_jacobian = [&](const Element& e) {
    const auto n = mesh.nodes_of(e);
    const auto at = [&](std::size_t k) { return mesh.nodes[static_cast<std::size_t>(n[k])]; };
    return dot(cross(at(1) - at(0), at(2) - at(0)), at(3) - at(0));
  };
  while (!candidates.empty()) { // moving a node may invert a neighbour
    std::vector<std::size_t> next;
    for (const std::size_t i : candidates) {
      const Element& e = mesh.elements[i];
      if (e.shape != Shape::tet10 ||
          min_jacobian(mesh, e) > kMinJacobianShare * straight_jacobian(e))
        continue;
      visit_sides(mesh, e, [&](std::size_t a, std::size_t b, std::size_t middle) {
        const Vec3 off = bend(mesh, a, b, middle);
        if (halvings[middle] == kHalvings || !(length(off) > 0))
          return;
        if (halvings[middle]++ == 0)
          straightened.push_back(middle);
        mesh.nodes[middle] = .5 * (mesh.nodes[a] + mesh.nodes[b]);
        if (halvings[middle] < kHalvings)
          mesh.nodes[middle] += .5 * off;
        next.insert(next.end(), around[middle].begin(), around[middle].end());
      });
    }
    std::sort(next.begin(), next.end());
    next.erase(std::unique(next.begin(), next.end()), next.end());
    candidates = std::move(next);
  }
  return straightened.size();
}

void check(const Mesh& mesh) {
  if (mesh.elements.empty())
    throw InputError("the mesh has no volume element: expected tet10, wedge15 or hex20");
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const Vec3& p = mesh.nodes[i];
    if (!(std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)))
      throw InputError("node " + std::to_string(i + 1) + ": coordinate is not a finite number");
  }
  for (std::size_t i = 0; i < mesh.elements.size(); ++i) {
    const Element& e = mesh.elements[i];
    const std::string label =
        "element " + std::to_string(i + 1) + " (" + std::string(name(e.shape)) + ")";
    const auto nodes = mesh.nodes_of(e);
    std::array<int, kMaxNodes> sorted{};
    std::copy(nodes.begin(), nodes.end(), sorted.begin());
    const auto end = sorted.begin() + static_cast<std::ptrdiff_t>(nodes.size());
    std::sort(sorted.begin(), end);
    if (sorted[0] < 0 || *(end - 1) >= static_cast<int>(mesh.nodes.size()))
      throw InputError(label + " uses a node that does not exist");
    if (std::adjacent_find(sorted.begin(), end) != end)
      throw InputError(label + " uses node " +
                       std::to_string(*std::adjacent_find(sorted.begin(), end) + 1) + " twice");
    if (const double min_determinant = min_jacobian(mesh, e); !(min_determinant > 0)) {
      const Vec3& p = mesh.nodes[static_cast<std::size_t>(nodes[0])];
      char at[96];
      std::snprintf(at, sizeof at, " near (%.4g, %.4g, %.4g) mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
      throw InputError(label + at + " is inverted: its Jacobian is " +
                       std::to_string(min_determinant) + ", expected above 0");
    }
  }
}

void check_range(const std::string& path, std::span<const Vec3> points) {
  constexpr double kLargest = 1e6; // m
  for (const Vec3& p : points)
    if (!(length(p) < kLargest))
      throw InputError(path + format(" has a point at (%g, %g, %g) m, expected one within %g m",
                                     p.x, p.y, p.z, kLargest));
}

} // namespace tactus::fem
