#pragma once
#include "core/geometry/vec3.hpp"

#include <array>
#include <span>
#include <vector>

namespace tactus::fem {

/// Small dense systems, solved with OpenBLAS's LAPACK. Matrices are column-major; `right` has one
/// or more columns, which become the solution.

/// Solves A x = b for A symmetric and positive definite (Cholesky; reads the lower triangle).
/// Returns false if A is not positive definite.
[[nodiscard]] bool solve_positive_definite(std::vector<double> a, std::span<double> right,
                                           std::size_t size);
/// Solves A x = b for any regular A (LU). Returns false if A is singular.
[[nodiscard]] bool solve_regular(std::vector<double> a, std::span<double> right, std::size_t size);
/// The least-squares solution of minimum norm of A x = b, A square of any rank (complete orthogonal
/// decomposition). One column.
[[nodiscard]] std::vector<double> solve_of_any_rank(std::vector<double> a,
                                                    std::span<const double> right);

/// Eigenpairs of a symmetric 3 x 3 matrix, by Jacobi's rotations.
struct Eigenpairs3 {
  std::array<double, 3> values; ///< ascending
  std::array<Vec3, 3> vectors;  ///< orthonormal
};
[[nodiscard]] Eigenpairs3 symmetric_eigenpairs(const std::array<Vec3, 3>& rows) noexcept;

} // namespace tactus::fem
