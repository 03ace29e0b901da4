#pragma once
#include "fem/modes/modes.hpp"

namespace tactus::fem {

/// Mass, centre of mass and inertia of a body.
struct MassProperties {
  double mass = 0;                 ///< kg
  Vec3 centre;                     ///< m
  std::array<double, 9> inertia{}; ///< about the centre, kg m^2, row by row
};
/// From the mass matrix applied to the nodes' coordinates.
[[nodiscard]] MassProperties mass_properties(const Mesh&, std::span<const Material>);

/// d ln f / d nu of each mode at first order, phi' (dK/dnu) phi / (2 lambda), for a body of one
/// isotropic material (Young's modulus held); empty otherwise.
[[nodiscard]] std::vector<double> poisson_slopes(const Mesh&, std::span<const Material>,
                                                 const Matrices&, const Modes&);

/// Loss factor of each mode: the materials' loss factors (or Rayleigh's a / omega + b omega)
/// weighted with the strain energy that the mode has in each. Springs are taken as lossless.
[[nodiscard]] std::vector<double> loss_factors(const Mesh&, std::span<const Material>,
                                               const Matrices&, const Modes&);

} // namespace tactus::fem
