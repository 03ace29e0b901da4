#pragma once
#include "fem/assembly/matrices.hpp"
#include "fem/mesh/surface.hpp"

namespace tactus::fem {

/// Nodes fixed in the chosen directions, or with a prescribed displacement (m).
struct FixedPatch {
  std::string name;
  std::vector<int> nodes;
  std::array<bool, 3> directions{true, true, true};
  Vec3 displacement_m{};
};

/// An elastic foundation of faces (Winkler): traction t_i = -(k_i / A) u_i, where k_i is the
/// stiffness of the whole patch in direction i, N/m, and A its area. It is weighted by area, so it
/// does not depend on the mesh of the faces.
struct SpringPatch {
  std::string name;
  std::vector<MeshFace> faces;
  Vec3 stiffness_n_per_m;
};

/// Has a 1 for each degree of freedom that a patch constrains.
[[nodiscard]] std::vector<std::uint8_t> held_directions(const Mesh&, std::span<const FixedPatch>);

/// Adds the consistent matrices (k_i / A) integral of N_a N_b dA of the patches to `stiffness`.
void add_springs(const Mesh&, std::span<const SpringPatch>, Matrices& into);

/// K_s u: the nodal forces on the springs at the displacement u, N. On the body they act with the
/// opposite sign.
[[nodiscard]] std::vector<double> spring_forces(const Mesh&, std::span<const SpringPatch>,
                                                std::span<const double> u);

/// Refuses supports that leave a connected piece of the body free to move, before any factor is
/// tried: one sentence that names the piece and the motion (translation along, rotation about an
/// axis through a point). A rigid motion of a piece is free if it moves no constrained direction
/// and no spring.
void check_supported(const Mesh&, std::span<const FixedPatch>, std::span<const SpringPatch>);

} // namespace tactus::fem
