#pragma once
#include "fem/assembly/matrices.hpp"

#include <memory>

namespace tactus::fem {

/// The cost of a factorisation, known from its symbolic phase.
struct FactorCost {
  double entries = 0;    ///< entries of the triangular factor
  double operations = 0; ///< floating-point operations
  double memory_bytes = 0;
};

/// Cholesky factor L of the shifted stiffness matrix: L L' = K + s M, by CHOLMOD's supernodal
/// method with nested dissection of the node graph (METIS). s > 0 keeps the matrix positive
/// definite for free bodies too; s = 0 needs supports that prevent every rigid motion, but no mass.
/// The rows and columns of constrained degrees of freedom are replaced by those of the identity.
class ShiftedFactor {
public:
  /// Symbolic phase. `shift` in rad^2/s^2.
  ShiftedFactor(const Matrices&, double shift);
  /// Copies the symbolic phase of `pattern`, a factor of the same node graph with other values.
  ShiftedFactor(const ShiftedFactor& pattern, const Matrices&, double shift);
  ~ShiftedFactor();
  ShiftedFactor(const ShiftedFactor&) = delete;
  ShiftedFactor& operator=(const ShiftedFactor&) = delete;

  [[nodiscard]] const FactorCost& cost() const noexcept { return cost_; }
  /// The numeric phase; call it once. Refuses if memory runs out or the matrix is not positive
  /// definite.
  void factorise();
  /// x = (K + s M)^-1 b for `columns` contiguous vectors; `x` and `b` may be the same memory.
  void solve(std::span<const double> b, std::span<double> x, std::size_t columns);
  /// Makes the copy of the factor in single precision that precondition() uses; it needs half the
  /// factor's memory.
  void prepare();
  /// Approximates solve() for one vector with the single-precision copy, with a relative error of
  /// about 1e-6, as a preconditioner. The time of a solve is that of reading the factor from
  /// memory, which single precision halves. Calls prepare() if necessary.
  void precondition(std::span<const double> b, std::span<double> x);
  /// Memory that the factor and its copy take now, bytes.
  [[nodiscard]] double memory_bytes() const noexcept;

private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
  FactorCost cost_;
};

/// Sets the number of threads of the dense kernels (OpenBLAS); with 1 thread, results are bit-equal
/// in every run.
void set_solver_threads(int count);

} // namespace tactus::fem
