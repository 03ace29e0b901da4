#pragma once
#include "fem/shapes/block.hpp"
#include "fem/statics/statics.hpp"
#include "solve.hpp"
#include "tetrahedra.hpp"

#include <algorithm>
#include <functional>
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

inline std::vector<double> even(double from, double to, int intervals) {
  std::vector<double> line;
  for (int i = 0; i <= intervals; ++i)
    line.push_back(from + (to - from) * i / intervals);
  return line;
}

inline Selection plane(int axis, double level) {
  Vector3 point, normal;
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
  for (Vector3& p : mesh.nodes) {
    const double s = p.x, c = std::cos(p.y), d = std::sin(p.y);
    const double outer = square ? b / std::max(c, d) : b, r = a + s * (outer - a);
    p = {r * c, r * d, p.z};
    for (int k = 0; k < 2; ++k) // cos(pi/2) is no zero
      if (std::abs(p[k]) < 1e-12 * b)
        p[k] = 0;
  }
  return mesh;
}

inline std::string refusal(const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& r) {
    return r.what();
  }
  return "";
}

inline bool mentions(const std::string& text, const std::string& part) {
  const bool found = text.find(part) != std::string::npos;
  if (!found)
    MESSAGE(text);
  return found;
}

} // namespace tactus::fem
