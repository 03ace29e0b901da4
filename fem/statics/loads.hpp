#pragma once
#include "fem/material/material.hpp"
#include "fem/mesh/surface.hpp"

#include <variant>

namespace tactus::fem {

/// A force per area on faces that keeps its direction, Pa.
struct Traction {
  std::string name;
  std::vector<MeshFace> faces;
  Vec3 traction_pa;
};
/// A total force, N, spread over faces with an even traction. Its sum is exact on any mesh.
struct TotalForce {
  std::string name;
  std::vector<MeshFace> faces;
  Vec3 force_n;
};
/// Pressure on faces, Pa: pushes against the outward normal when positive.
struct Pressure {
  std::string name;
  std::vector<MeshFace> faces;
  double pressure_pa = 0;
};
/// Gravity, or any constant acceleration of the frame: rho g on the whole volume, m/s^2.
struct Gravity {
  Vec3 acceleration{0, -9.80665, 0};
};
/// A force on one node, N. The stress under it grows without bound as the mesh is refined.
struct PointForce {
  int node = 0;
  Vec3 force_n;
};
/// The force of a bolt or pin, without friction, on the wall of a round hole, N. The pressure on
/// the wall is p = max(0, -n . e), a cosine over the half that faces the force. e is found by
/// Newton's method so that the integral of -p n is `force_n` exactly on the meshed wall. The force
/// must be perpendicular to the hole's axis.
struct BoltLoad {
  std::string name;
  std::vector<MeshFace> faces;
  Vec3 axis; ///< axis of the hole, of any length
  Vec3 force_n;
};

using Load = std::variant<Traction, TotalForce, Pressure, Gravity, PointForce, BoltLoad>;

/// The consistent nodal forces f_a = integral of N_a t over the faces (tri3, tri6, quad4, quad8) or
/// N_a rho g over the volume, N, dofs() long (Zienkiewicz & Taylor, The Finite Element Method, vol.
/// 1, ch. 2). Refuses missing faces or nodes, values that are not finite, and a bolt force that its
/// wall cannot support, and names the load.
[[nodiscard]] std::vector<double> load_vector(const Mesh&, std::span<const Material>,
                                              std::span<const Load>);

/// The integral of dA over faces, m^2.
[[nodiscard]] double area(const Mesh&, std::span<const MeshFace>);

} // namespace tactus::fem
