#include "fem/shapes/ball.hpp"

#include "fem/shapes/section.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr double kCore = .5;  ///< half the inner cube's side, relative to the radius
constexpr double kBulge = .5; ///< bulge of the inner cube's faces: 0 flat, 1 a sphere

/// Numbers of intervals along half the cube's side, and from there to the sphere.
std::array<double, 2> ball_cells(double radius, double h, int at_least, const SweepGrid* given) {
  if (given)
    return {static_cast<double>(given->line[0].size() - 1),
            static_cast<double>(given->line[1].size() - 1)};
  const auto cells = [&](double side) {
    return std::max<double>(at_least, std::ceil(side / h - 1e-9));
  };
  return {cells(kCore * radius), cells((1 - kCore) * radius)};
}

/// Maps the cube [-1, 1]^3 onto the unit ball, and cubes about the middle onto smooth closed
/// surfaces: x' = x sqrt(1 - y^2/2 - z^2/2 + y^2 z^2/3), cyclically. The cube's faces map onto the
/// sphere.
Vec3 onto_ball(const Vec3& p) noexcept {
  const Vec3 q{p.x * p.x, p.y * p.y, p.z * p.z};
  return {p.x * std::sqrt(1 - q.y / 2 - q.z / 2 + q.y * q.z / 3),
          p.y * std::sqrt(1 - q.z / 2 - q.x / 2 + q.z * q.x / 3),
          p.z * std::sqrt(1 - q.x / 2 - q.y / 2 + q.x * q.y / 3)};
}

Vec3 in_core(const Vec3& p) noexcept { return kCore * ((1 - kBulge) * p + kBulge * onto_ball(p)); }

} // namespace

MeshSize size_of_ball(double radius, double h, int at_least, const SweepGrid* given) {
  const auto [c, a] = ball_cells(radius, h, at_least, given);
  const double m = 2 * c; // number of intervals along the cube's side
  const double skin_corners = 6 * m * m + 2, skin_edges = 12 * m * m, skin_faces = 6 * m * m;
  const double corners = (m + 1) * (m + 1) * (m + 1) + a * skin_corners;
  const double edges = 3 * m * (m + 1) * (m + 1) + a * (skin_corners + skin_edges);
  MeshSize size;
  size.elements = m * m * m + a * skin_faces;
  size.nodes = corners + edges;
  // Pairs of nodes of each element, minus those of inner faces, plus inner edges, minus corners.
  size.node_pairs = 210 * size.elements - 36 * (6 * size.elements - skin_faces) / 2 +
                    6 * (edges - skin_edges) - (corners - skin_corners);
  size.skin_triangles = 6 * skin_faces;
  size.cells.fill(std::cbrt(size.elements));
  size.nodes_made = 20 * size.elements;
  size.volume = 4 * std::numbers::pi / 3 * radius * radius * radius;
  size.box = {2 * radius, 2 * radius, 2 * radius};
  return size;
}

namespace {

SweepGrid ball_grid(double radius, double h, int at_least) {
  SweepGrid grid;
  const auto [c, a] = ball_cells(radius, h, at_least, nullptr);
  const int cells = static_cast<int>(c), out = static_cast<int>(a);
  grid.line = {divide({0, 1, 1. / cells, cells}), divide({0, 1, 1. / out, out}), {0, 1}};
  grid.kept = {{{0, 1}, {0, 1}, {0, 1}}};
  // d ln N / d ln c and d ln N / d ln a where c = a; the third direction is unused.
  grid.power = {2.25, .75, 1};
  return grid;
}

} // namespace

SweptBody make_ball(double radius, double h, int at_least, const SweepGrid* given) {
  SweptBody body;
  body.grid = given ? *given : ball_grid(radius, h, at_least);
  const SweepGrid& grid = body.grid;
  const std::vector<double>& out = grid.line[1];
  std::vector<double> across; // the first direction's lines and their mirror images
  for (auto u = grid.line[0].rbegin(); u != grid.line[0].rend() - 1; ++u)
    across.push_back(-*u);
  across.insert(across.end(), grid.line[0].begin(), grid.line[0].end());
  const auto half = static_cast<int>(grid.line[0].size()) - 1;
  const auto mirrored = [half](std::size_t i) {
    const int j = static_cast<int>(i);
    return j < half ? half - 1 - j : j - half;
  };
  const auto between = [](const std::vector<double>& lines, std::size_t i, double at) {
    return lines[i] + .5 * (1 + at) * (lines[i + 1] - lines[i]);
  };
  Mesh& mesh = body.mesh;
  const auto add = [&](const std::array<int, 3>& interval, auto&& position) {
    std::array<int, 20> nodes{};
    const auto reference = reference_nodes(Shape::hex20);
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      nodes[n] = static_cast<int>(mesh.nodes.size());
      mesh.nodes.push_back(radius * position(reference[n]));
    }
    mesh.add(Shape::hex20, nodes);
    mesh.elements.back().interval = interval;
  };
  const std::size_t cells = across.size() - 1;
  for (std::size_t k = 0; k < cells; ++k)
    for (std::size_t j = 0; j < cells; ++j)
      for (std::size_t i = 0; i < cells; ++i)
        add({mirrored(i), mirrored(j), mirrored(k)}, [&](const Vec3& r) {
          return in_core(
              {between(across, i, r.x), between(across, j, r.y), between(across, k, r.z)});
        });
  for (int axis = 0; axis < 3; ++axis)
    for (const double side : {-1., 1.})
      for (std::size_t k = 0; k + 1 < out.size(); ++k)
        for (std::size_t j = 0; j < cells; ++j)
          for (std::size_t i = 0; i < cells; ++i)
            // Right-handed, since the first and second direction turn about the outward one.
            add({mirrored(i), mirrored(j), half + static_cast<int>(k)}, [&](const Vec3& r) {
              Vec3 face;
              face[axis] = side;
              face[(axis + 1) % 3] = side * between(across, i, r.x);
              face[(axis + 2) % 3] = between(across, j, r.y);
              const double t = between(out, k, r.z);
              return (1 - t) * in_core(face) + t * onto_ball(face);
            });
  merge_nodes(mesh, 1e-8 * radius);
  // Quadratic edges through nodes on the sphere enclose too small a volume. The resulting error of
  // low modes' frequencies is as large as that of the elements, and the error estimate does not
  // include it.
  const double exact = 4 * std::numbers::pi / 3 * radius * radius * radius;
  const double scale = std::cbrt(exact / volume(mesh));
  for (Vec3& p : mesh.nodes)
    p = scale * p;
  return body;
}

} // namespace tactus::fem
