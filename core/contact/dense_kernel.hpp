#pragma once

#include <cstddef>

namespace tactus::contact {

/// A symmetric positive definite matrix, column by column, `stride` numbers each: a whole multiple
/// of kModeLanes, aligned for vectors. Only the part from the diagonal down counts; what lies above
/// and beyond `count` must be finite.
struct DenseView {
  double* at;
  std::size_t count, stride;
  [[nodiscard]] double& operator()(std::size_t row, std::size_t column) const noexcept {
    return at[column * stride + row];
  }
};

/// Solving the small systems of contacts that answer each other, one copy for each instruction set;
/// every set gives the same bits.
class DenseKernel {
public:
  virtual ~DenseKernel() = default;
  /// Cholesky's factorisation, in place; pivots that rounding has made smaller count as `least`.
  virtual void factorise(const DenseView& matrix, double min_pivot) const noexcept = 0;
  /// Solves with the factorised matrix for two right sides of `stride` numbers, in place.
  virtual void substitute(const DenseView& factor, double* first,
                          double* second) const noexcept = 0;
  /// matrix += factor x x', from the diagonal down; x of `stride` numbers.
  virtual void add_square(const DenseView& matrix, const double* x,
                          double factor) const noexcept = 0;
  /// One column: to[i] = factor scale[i] y[i], sum[i] += weight y[i].
  virtual void take_column(double* to, double* sum, const double* y, const double* scale,
                           double factor, double weight, std::size_t padded) const noexcept = 0;
};

[[nodiscard]] const DenseKernel& dense_kernel() noexcept;
[[nodiscard]] const DenseKernel& baseline_dense_kernel() noexcept;

} // namespace tactus::contact
