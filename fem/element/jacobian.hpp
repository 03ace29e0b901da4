#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// dx/d(r,s,t) at one reference point: row[i] holds the derivatives of x by the i-th coordinate.
struct Jacobian {
  std::array<Vec3, 3> row;
  double determinant = 0;

  /// Derivative in space of a function with the reference derivative `d`.
  [[nodiscard]] Vec3 to_space(const Vec3& d) const noexcept {
    const Vec3 a = cross(row[1], row[2]), b = cross(row[2], row[0]), c = cross(row[0], row[1]);
    return (1 / determinant) * (d.x * a + d.y * b + d.z * c);
  }
};

[[nodiscard]] inline Jacobian jacobian(const Mesh& mesh, const Element& e,
                                       const ShapeValues& values) noexcept {
  Jacobian j;
  const auto nodes = mesh.nodes_of(e);
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const Vec3& x = mesh.nodes[static_cast<std::size_t>(nodes[a])];
    j.row[0] += values.derivative[a].x * x;
    j.row[1] += values.derivative[a].y * x;
    j.row[2] += values.derivative[a].z * x;
  }
  j.determinant = dot(j.row[0], cross(j.row[1], j.row[2]));
  return j;
}

} // namespace tactus::fem
