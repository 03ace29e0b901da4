#pragma once
#include "fem/modes/shifted_factor.hpp"
#include "fem/statics/loads.hpp"
#include "fem/statics/selection.hpp"
#include "fem/statics/stress.hpp"
#include "fem/statics/supports.hpp"

#include <functional>
#include <memory>

namespace tactus::fem {

/// A problem of linear elasticity on a mesh: small displacements, K u = f. All parts refer to the
/// mesh by numbers of nodes and faces, so the same model holds while its nodes move.
struct StaticModel {
  std::vector<Material> materials; ///< one a region
  std::vector<FixedPatch> fixed;
  std::vector<SpringPatch> springs;
  std::vector<Load> loads;
};

/// The assembled equations. `matrices.stiffness` holds elements and springs, `matrices.constrained`
/// marks the fixed directions, `matrices.mass` is empty.
struct StaticSystem {
  Matrices matrices;
  std::vector<double> load;       ///< f, N
  std::vector<double> prescribed; ///< of held directions, m; 0 elsewhere

  /// Refuses a bad model in one sentence: materials, supports (check_supported()), loads.
  StaticSystem(const Mesh&, const StaticModel&);

  /// f - K u_prescribed, with zero in held directions: the right side for the free ones.
  [[nodiscard]] std::vector<double> right_side() const;
};

struct StaticSolution {
  std::vector<double> displacement; ///< u, m
  std::vector<double> reaction;     ///< K u - f in held directions, N; 0 elsewhere
  double strain_energy = 0;         ///< u' K u / 2, springs included, J
};

/// u from the solution of the free directions: prescribed values, reactions and energy added.
[[nodiscard]] StaticSolution completed(const StaticSystem&, std::vector<double> free_displacement);

/// The sum of the reactions and the forces of the springs on the body, N. With the loads it is
/// zero.
[[nodiscard]] Vec3 support_force(const Mesh&, const StaticModel&, const StaticSolution&);
/// The sum of nodal forces, N.
[[nodiscard]] Vec3 sum_of_forces(std::span<const double> nodal);

/// A solved problem with its factor, for further right-hand sides.
struct StaticAnalysis {
  StaticSystem system;
  std::unique_ptr<ShiftedFactor> factor;
  StaticSolution solution;
};

/// Assembles, factorises (CHOLMOD), solves. `predict` is called with the predicted cost before the
/// factorisation and may throw to refuse it.
[[nodiscard]] StaticAnalysis
solve_static(const Mesh&, const StaticModel&,
             const std::function<void(const FactorCost&)>& predict = {});

} // namespace tactus::fem
