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
/// mesh by numbers of nodes and faces, so the same model applies while the nodes move.
struct StaticModel {
  std::vector<Material> materials; ///< one per region
  std::vector<FixedPatch> fixed;
  std::vector<SpringPatch> springs;
  std::vector<Load> loads;
};

/// The assembled equations. `matrices.stiffness` holds elements and springs, `matrices.constrained`
/// marks the fixed directions, `matrices.mass` is empty.
struct StaticSystem {
  Matrices matrices;
  std::vector<double> load;       ///< f, N
  std::vector<double> prescribed; ///< displacement of constrained directions, m; 0 elsewhere

  /// Refuses invalid materials, supports (check_supported()) or loads in one sentence.
  StaticSystem(const Mesh&, const StaticModel&);

  /// f - K u_prescribed, with zero in constrained directions: the right side for the free
  /// directions.
  [[nodiscard]] std::vector<double> right_side() const;
};

struct StaticSolution {
  std::vector<double> displacement; ///< u, m
  std::vector<double> reaction;     ///< K u - f in constrained directions, N; 0 elsewhere
  double strain_energy = 0;         ///< u' K u / 2, with springs, J
};

/// Completes the solution of the free directions with prescribed values, reactions and energy.
[[nodiscard]] StaticSolution completed(const StaticSystem&, std::vector<double> free_displacement);

/// The sum of the reactions and the forces of the springs on the body, N. Its sum with the loads is
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

/// Assembles, factorises (CHOLMOD) and solves. `predict` is called with the predicted cost before
/// the factorisation and may throw to refuse it.
[[nodiscard]] StaticAnalysis
solve_static(const Mesh&, const StaticModel&,
             const std::function<void(const FactorCost&)>& predict = {});

} // namespace tactus::fem
