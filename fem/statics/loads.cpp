#include "fem/statics/loads.hpp"

#include "fem/assembly/matrices.hpp"
#include "fem/element/tabulated.hpp"
#include "fem/statics/face_points.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactus::fem {
namespace {

void check_finite(const Vec3& v, const std::string& label) {
  if (!std::isfinite(v.x) || !std::isfinite(v.y) || !std::isfinite(v.z))
    throw InputError(label + ": a component is not a finite number");
}

void add(std::vector<double>& f, std::size_t node, const Vec3& force) {
  for (std::size_t i = 0; i < 3; ++i)
    f[3 * node + i] += force[static_cast<int>(i)];
}

/// f_a += integral of N_a traction(point) over the faces; `traction` returns a force in N for an
/// area vector.
template <class Force>
void add_over(const Mesh& mesh, std::span<const MeshFace> faces, std::vector<double>& f,
              Force&& force_at) {
  for (const MeshFace& face : faces) {
    const FaceNodes nodes = face_nodes(mesh, face);
    for (const FacePoint& p : face_points(mesh, face)) {
      const Vec3 force = force_at(p.area);
      for (std::size_t a = 0; a < nodes.count; ++a)
        add(f, nodes.node[a], p.value[a] * force);
    }
  }
}

/// e of a bolt's pressure p = max(0, -n . e): found by Newton's method from the integral of p (-n)
/// dA = force. The integral is M(e) e with M = integral of n n' over the loaded half. M is also its
/// derivative, so a step is e = M(e)^-1 force.
Vec3 bolt_pressure(const Mesh& mesh, const BoltLoad& bolt, const std::string& label) {
  const double size = length(bolt.axis), total = length(bolt.force_n);
  if (!(size > 0) || !std::isfinite(size))
    throw InputError(label + " has no axis, expected the direction of the hole");
  const Vec3 axis = (1 / size) * bolt.axis;
  if (total == 0)
    return {};
  if (std::abs(dot(axis, bolt.force_n)) > 1e-6 * total)
    throw InputError(label + " has a force along the hole's axis, which a wall without friction "
                             "cannot support: apply that component to a face as a total force");
  const Vec3 u = (1 / total) * (bolt.force_n - dot(axis, bolt.force_n) * axis), v = cross(axis, u);
  const double whole = area(mesh, bolt.faces);
  Vec3 e = u;
  for (int step = 0; step < 50; ++step) {
    double uu = 0, uv = 0, vv = 0;
    for (const MeshFace& face : bolt.faces)
      for (const FacePoint& p : face_points(mesh, face))
        if (dot(p.area, e) < 0) {
          const double area = length(p.area), nu = dot(p.area, u) / area,
                       nv = dot(p.area, v) / area;
          uu += area * nu * nu;
          uv += area * nu * nv;
          vv += area * nv * nv;
        }
    const double determinant = uu * vv - uv * uv;
    if (!(determinant > 1e-9 * whole * whole)) // all normals are along the axis or parallel
      break;
    const Vec3 next = (total / determinant) * (vv * u - uv * v);
    const double change = length(next - e);
    e = next;
    if (change <= 1e-13 * length(e))
      return e;
  }
  throw InputError(label +
                   " acts on faces that cannot support it, expected the wall of a round hole");
}

void add_load(const Mesh& mesh, std::span<const Material>, const Traction& t,
              std::vector<double>& f) {
  const std::string label = "traction " + t.name;
  check_faces(mesh, t.faces, label);
  check_finite(t.traction_pa, label);
  add_over(mesh, t.faces, f, [&](const Vec3& da) { return length(da) * t.traction_pa; });
}

void add_load(const Mesh& mesh, std::span<const Material>, const TotalForce& t,
              std::vector<double>& f) {
  const std::string label = "force " + t.name;
  check_faces(mesh, t.faces, label);
  check_finite(t.force_n, label);
  const double whole = area(mesh, t.faces);
  add_over(mesh, t.faces, f, [&](const Vec3& da) { return length(da) / whole * t.force_n; });
}

void add_load(const Mesh& mesh, std::span<const Material>, const Pressure& p,
              std::vector<double>& f) {
  const std::string label = "pressure " + p.name;
  check_faces(mesh, p.faces, label);
  check_finite({p.pressure_pa, 0, 0}, label);
  add_over(mesh, p.faces, f, [&](const Vec3& da) { return -p.pressure_pa * da; });
}

void add_load(const Mesh& mesh, std::span<const Material> materials, const Gravity& g,
              std::vector<double>& f) {
  check_finite(g.acceleration, "gravity");
  const auto laws = elastic_laws(mesh, materials);
  for (const Element& e : mesh.elements) {
    const double density = laws[static_cast<std::size_t>(e.region)].density;
    const Tabulated& table = at_mass_points(e.shape);
    const auto nodes = mesh.nodes_of(e);
    for (std::size_t q = 0; q < table.weights.size(); ++q) {
      const double mass =
          density * table.weights[q] * jacobian(mesh, e, table.values[q]).determinant;
      for (std::size_t a = 0; a < nodes.size(); ++a)
        add(f, static_cast<std::size_t>(nodes[a]),
            mass * table.values[q].value[a] * g.acceleration);
    }
  }
}

void add_load(const Mesh& mesh, std::span<const Material>, const PointForce& p,
              std::vector<double>& f) {
  if (p.node < 0 || static_cast<std::size_t>(p.node) >= mesh.nodes.size())
    throw InputError("a point force acts on node " + std::to_string(p.node + 1) +
                     ", the mesh has " + std::to_string(mesh.nodes.size()));
  check_finite(p.force_n, "the point force on node " + std::to_string(p.node + 1));
  add(f, static_cast<std::size_t>(p.node), p.force_n);
}

void add_load(const Mesh& mesh, std::span<const Material>, const BoltLoad& b,
              std::vector<double>& f) {
  const std::string label = "bolt " + b.name;
  check_faces(mesh, b.faces, label);
  check_finite(b.force_n, label);
  const Vec3 e = bolt_pressure(mesh, b, label);
  add_over(mesh, b.faces, f,
           [&](const Vec3& da) { return -1 / length(da) * std::max(0.0, -dot(da, e)) * da; });
}

} // namespace

std::vector<double> load_vector(const Mesh& mesh, std::span<const Material> materials,
                                std::span<const Load> loads) {
  std::vector<double> f(mesh.dofs(), 0.0);
  for (const Load& load : loads)
    std::visit([&](const auto& own) { add_load(mesh, materials, own, f); }, load);
  return f;
}

double area(const Mesh& mesh, std::span<const MeshFace> faces) {
  double sum = 0;
  for (const MeshFace& face : faces)
    for (const FacePoint& p : face_points(mesh, face))
      sum += length(p.area);
  return sum;
}

} // namespace tactus::fem
