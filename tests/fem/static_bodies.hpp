#pragma once
#include "fem/shapes/block.hpp"
#include "fem/statics/statics.hpp"
#include "solve.hpp"
#include "tetrahedra.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {

inline Material steel(double poisson = 0.3) {
  Material m;
  m.name = "steel";
  m.density = 7850;
  m.young_pa = {2.1e11, 0, 0};
  m.poisson = {poisson, 0, 0};
  return m;
}

/// Spruce whose grain runs askew to the axes.
inline Material oblique_spruce() {
  Material wood;
  wood.name = "spruce";
  wood.density = 450;
  wood.young_pa = {11e9, 0.8e9, 0.45e9};
  wood.poisson = {0.44, 0.38, 0.36};
  wood.shear_pa = {0.04e9, 0.6e9, 0.75e9};
  wood.axis_1 = {1, 1, 0};
  wood.axis_2 = {-1, 1, 0};
  return wood;
}

inline std::vector<double> even(double from, double to, int intervals) {
  std::vector<double> line;
  for (int i = 0; i <= intervals; ++i)
    line.push_back(from + (to - from) * i / intervals);
  return line;
}

inline Selection plane(int axis, double level) {
  Vec3 point, normal;
  point[axis] = level;
  normal[axis] = 1;
  return {OnPlane{point, normal}, 1e-9};
}

/// The cantilever of the specification: 200 x 20 x 20 mm along x, clamped at x = 0, 100 N downwards
/// (-z) spread over the face at x = 200 mm.
struct Cantilever {
  static constexpr double kLength = .2, kHeight = .02, kForce = 100;
  Mesh mesh;
  StaticModel model;

  Cantilever(Mesh own, double poisson) : mesh(std::move(own)) {
    set_solver_threads(1);
    model.materials = {steel(poisson)};
    model.fixed = {{"wall", select_nodes(mesh, plane(0, 0)), {true, true, true}, {}}};
    model.loads = {TotalForce{"tip", select_faces(mesh, plane(0, kLength)), {0, 0, -kForce}}};
  }
  /// 19 683 degrees of freedom in tet10.
  static Mesh tetrahedra(int across = 4) {
    return tetrahedral_box({10 * across, across, across}, {kLength, kHeight, kHeight}, true);
  }
  [[nodiscard]] StaticAnalysis solve() const { return solve_static(mesh, model); }
  /// Mean deflection of the loaded face by area, m: the work of the force over the force.
  [[nodiscard]] double tip(std::span<const double> u) const {
    const auto f = load_vector(mesh, model.materials, model.loads);
    double work = 0;
    for (std::size_t i = 0; i < f.size(); ++i)
      work += f[i] * u[i];
    return work / kForce;
  }
};

/// A quarter of a plate from a hole of the radius `a` to a square of half side `b`, or to a circle
/// of the radius `b`: hex20 between x, y >= 0 and 0 <= z <= `thickness`, one layer. Radial lines
/// grow geometrically by `growth`.
inline Mesh quarter_plate(double a, double b, double thickness, bool square, int radial, int around,
                          double growth) {
  std::vector<double> line{0};
  double step = 1;
  for (int i = 0; i < radial; ++i, step *= growth)
    line.push_back(line.back() + step);
  for (double& s : line)
    s /= line.back() == 0 ? 1 : (std::pow(growth, radial) - 1) / (growth - 1);
  Mesh mesh = block(line, even(0, std::numbers::pi / 2, around), even(0, thickness, 1));
  for (Vec3& p : mesh.nodes) {
    const double s = p.x, c = std::cos(p.y), d = std::sin(p.y);
    const double outer = square ? b / std::max(c, d) : b, r = a + s * (outer - a);
    p = {r * c, r * d, p.z};
    for (int k = 0; k < 2; ++k) // cos(pi/2) is no zero
      if (std::abs(p[k]) < 1e-12 * b)
        p[k] = 0;
  }
  return mesh;
}

/// Planes of symmetry: nodes in them slide in them.
inline std::vector<FixedPatch> symmetry(const Mesh& mesh,
                                        std::initializer_list<std::pair<int, double>> planes) {
  std::vector<FixedPatch> fixed;
  for (const auto& [axis, level] : planes)
    fixed.push_back({"symmetry",
                     select_nodes(mesh, plane(axis, level)),
                     {axis == 0, axis == 1, axis == 2},
                     {}});
  return fixed;
}

/// A node's three numbers of an array over degrees of freedom.
inline Vec3 of_node(std::span<const double> u, std::size_t n) {
  return {u[3 * n], u[3 * n + 1], u[3 * n + 2]};
}

/// The mesh and, apart from it, the same once more, moved by `shift`.
inline Mesh two_of(const Mesh& mesh, const Vec3& shift) {
  Mesh two = mesh;
  for (const Vec3& p : mesh.nodes)
    two.nodes.push_back(p + shift);
  for (const Element& e : mesh.elements) {
    std::vector<int> nodes(mesh.nodes_of(e).begin(), mesh.nodes_of(e).end());
    for (int& n : nodes)
      n += static_cast<int>(mesh.nodes.size());
    two.add(e.shape, nodes);
  }
  return two;
}

} // namespace tactus::fem
