#pragma once
#include "fem/modes/modes.hpp"

namespace tactus::fem {

/// Mass, centre of mass and inertia of a body.
struct MassProperties {
  double mass = 0;                 ///< kg
  Vec3 centre;                     ///< m
  std::array<double, 9> inertia{}; ///< about the centre, kg m^2, row by row
};
/// Computed from the mass matrix applied to the nodes' coordinates.
[[nodiscard]] MassProperties mass_properties(const Mesh&, std::span<const Material>);

/// d ln f / d nu of each mode at first order, phi' (dK/dnu) phi / (2 lambda), for a body of one
/// isotropic material at constant Young's modulus; empty otherwise.
[[nodiscard]] std::vector<double> poisson_slopes(const Mesh&, std::span<const Material>,
                                                 const Matrices&, const Modes&);

/// Loss factor of each mode: the materials' loss factors (or Rayleigh's a / omega + b omega)
/// weighted with the mode's strain energy in each material. Springs count as lossless.
[[nodiscard]] std::vector<double> loss_factors(const Mesh&, std::span<const Material>,
                                               const Matrices&, const Modes&);

} // namespace tactus::fem
