#pragma once
#include "fem/mesh/mesh_size.hpp"
#include "fem/modes/shifted_factor.hpp"

#include <optional>

namespace tactus::fem {

/// The work to be done on a mesh: the input of the prediction.
struct Workload {
  MeshSize mesh;
  double modes = 40;
  bool residual = false;
  bool estimated = false;        ///< whether modes' errors are estimated
                                 ///< (fem/error/error_estimate.hpp)
  double acoustic_triangles = 0; ///< 0 without radiation
  double solutions = 0;          ///< air solutions, groups of modes times ratios; 0 for one per
                                 ///< mode
  bool factor_elsewhere = false; ///< other processes factorise; not counted here
  double flops_per_second = 8e9; ///< speed of a dense product with the threads used
  double retained_bytes = 0;     ///< memory of another mesh's results, kept meanwhile
};

/// Memory of a mesh with its matrices and modes, bytes.
[[nodiscard]] double bytes_of_results(const MeshSize&, double modes);

/// The predicted cost: the peak memory of the whole process, the stage that reaches it, and the
/// time.
struct Cost {
  double bytes = 0;
  double seconds = 0;        ///< all stages, within a factor of two or three
  double factor_seconds = 0; ///< time of the factorisation in `seconds`
  const char* stage = "";
};

/// Predicts the factor's entries and operations before the equations are ordered: nested dissection
/// of a block of `cells` elements by planes across its longest side (George 1973). A separator of s
/// unknowns whose block has b on older separators adds s^2/2 + s b entries and s^3/3 + s^2 b + s
/// b^2 operations.
[[nodiscard]] FactorCost predict_factor(const MeshSize&);

/// The cost of all stages; `exact`, from the symbolic factorisation, replaces the predicted cost of
/// the factor. Memory is right within kCostMargin on meshes of shapes and of gmsh
/// (tests/fem/cost_test.cpp and test_modal_fem_budget.py).
[[nodiscard]] Cost predict_cost(const Workload&, const std::optional<FactorCost>& exact = {});

inline constexpr double kCostMargin = 1.3;

} // namespace tactus::fem
