#pragma once
#include "fem/assembly/matrices.hpp"

namespace tactus::fem {

/// The rigid-body motions that the supports allow, as M-orthonormal columns dofs() long.
///
/// Strain energy vanishes only if each connected part moves as a rigid body. So every such motion
/// is a combination of three translations and three rotations of each part. The motions that cost
/// no energy and move no fixed node are the null space of a small matrix. Their number is found and
/// not assumed: 6 for a free body, 1 for a body on an axle, 0 for a clamped body, 12 for two free
/// parts.
[[nodiscard]] std::vector<double> rigid_motions(const Mesh&, const Matrices&);

} // namespace tactus::fem
