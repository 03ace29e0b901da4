#pragma once
#include "fem/material/material.hpp"
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// The elastic law of a material in the form that element integrals need: Lamé's constants if it is
/// isotropic, and the elastic matrix C.
struct ElasticLaw {
  explicit ElasticLaw(const Material&);
  bool isotropic;
  double lame_lambda = 0, lame_mu = 0; ///< Pa, if isotropic
  double density;                      ///< kg/m^3
  ElasticMatrix matrix;                ///< Pa
};

/// K_e = ∫ B' C B dV, N/m, as node blocks: entry 9 (a n + b) + 3 i + j couples component i of node
/// a with component j of node b; only b <= a is filled.
using StiffnessBlocks = std::array<double, 9 * kMaxNodes * kMaxNodes>;
void element_stiffness(const Mesh&, const Element&, const ElasticLaw&, StiffnessBlocks& out);

/// M_e = ∫ rho N_a N_b dV, kg: entry a n + b; the same for each component. Only b <= a is filled.
using MassEntries = std::array<double, kMaxNodes * kMaxNodes>;
void element_mass(const Mesh&, const Element&, double density, MassEntries& out);

} // namespace tactus::fem
