#pragma once
#include "fem/assembly/matrices.hpp"

#include <memory>

namespace tactus::fem {

/// The cost of a factorisation, known from its symbolic phase.
struct FactorCost {
  double entries = 0;    ///< of the triangular factor
  double operations = 0; ///< floating-point operations
  double memory_bytes = 0;
};

/// L L' = K + s M by supernodal Cholesky (CHOLMOD) with nested dissection of the node graph
/// (METIS). s > 0 keeps the matrix positive definite for free bodies too. Held directions become
/// identities. s = 0 needs no mass, and supports that hold every rigid motion.
class ShiftedFactor {
public:
  /// Symbolic phase. `shift` in rad^2/s^2.
  ShiftedFactor(const Matrices&, double shift);
  /// The symbolic phase of a factor of the same graph, for other numbers in the matrix.
  ShiftedFactor(const ShiftedFactor& pattern, const Matrices&, double shift);
  ~ShiftedFactor();
  ShiftedFactor(const ShiftedFactor&) = delete;
  ShiftedFactor& operator=(const ShiftedFactor&) = delete;

  [[nodiscard]] const FactorCost& cost() const noexcept { return cost_; }
  /// The numeric phase; call it once. Refuses when memory runs out or the matrix is not positive
  /// definite.
  void factorise();
  /// x = (K + s M)^-1 b for `columns` contiguous vectors; `x` and `b` may be the same memory.
  void solve(std::span<const double> b, std::span<double> x, std::size_t columns);
  /// The same for one vector with a copy of the factor in single precision, right to some 1e-6: a
  /// preconditioner. The time of a solve is that of reading the factor from memory, and single
  /// precision halves it. The copy is made by prepare() or at the first call and costs half the
  /// factor's memory.
  void prepare();
  void precondition(std::span<const double> b, std::span<double> x);
  /// Memory that the factor and its copy take now, bytes.
  [[nodiscard]] double memory_bytes() const noexcept;

private:
  struct Implementation;
  std::unique_ptr<Implementation> impl_;
  FactorCost cost_;
};

/// How many threads the dense kernels use; 1 makes results repeat bit for bit.
void set_solver_threads(int count);

} // namespace tactus::fem
