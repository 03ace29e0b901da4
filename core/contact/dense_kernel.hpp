#pragma once

#include "core/dsp/vector_set.hpp"

#include <cstddef>

namespace tactus::contact {

/// A symmetric positive definite matrix, stored by columns of `stride` numbers. stride is a
/// multiple of kModeLanes, and `at` is aligned for vectors. Only the lower triangle is used; the
/// elements above the diagonal and beyond `count` must be finite.
struct DenseView {
  double* at;
  std::size_t count, stride;
  [[nodiscard]] double& operator()(std::size_t row, std::size_t column) const noexcept {
    return at[column * stride + row];
  }
};

/// Weights of DenseKernel::add_column().
struct ColumnWeights {
  const double* row; ///< one weight per row
  double column;
  double sum;
};

/// Cholesky solver for the small dense systems of coupled contacts. Each instruction set has its
/// own implementation; all give the same bits.
class DenseKernel {
public:
  virtual ~DenseKernel() = default;
  /// Cholesky factorisation in place. Pivots below `min_pivot` count as `min_pivot`.
  virtual void factorise(const DenseView& matrix, double min_pivot) const noexcept = 0;
  /// Solves with the factorised matrix for two right-hand sides of `stride` numbers, in place.
  virtual void substitute(const DenseView& factor, double* first,
                          double* second) const noexcept = 0;
  /// matrix += factor x x^T, lower triangle; x has `stride` numbers.
  virtual void add_square(const DenseView& matrix, const double* x,
                          double factor) const noexcept = 0;
  /// One column: to[i] = weights.column weights.row[i] y[i], sum[i] += weights.sum y[i].
  virtual void add_column(double* to, double* sum, const double* y, const ColumnWeights& weights,
                          std::size_t padded) const noexcept = 0;
};

/// The implementation for the widest instruction set that the processor supports, up to `widest`.
[[nodiscard]] const DenseKernel* dense_kernel(simd::VectorSet widest) noexcept;
[[nodiscard]] const DenseKernel* dense_kernel(simd::Baseline) noexcept;
[[nodiscard]] const DenseKernel* dense_kernel(simd::Avx2) noexcept;

} // namespace tactus::contact
