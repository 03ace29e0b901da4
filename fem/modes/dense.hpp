#pragma once
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::fem {

/// C = A' B for A n x p and B n x q, all column-major; C is p x q.
[[nodiscard]] std::vector<double> transposed_product(std::span<const double> a, std::size_t p,
                                                     std::span<const double> b, std::size_t q,
                                                     std::size_t n);
/// The columns of a matrix, one after the other.
struct Columns {
  std::span<const double> values;
  std::size_t count;
};
/// B += factor A C for A n x p, C p x q and B n x q, column-major.
void add_product(double factor, const Columns& a, const Columns& c, std::span<double> b,
                 std::size_t n);

struct Eigenpairs {
  std::vector<double> values;  ///< ascending
  std::vector<double> vectors; ///< column-major, orthonormal
};
/// All eigenpairs of a small symmetric matrix, column-major.
[[nodiscard]] Eigenpairs symmetric_eigenpairs(std::span<const double> matrix, std::size_t size);

/// The speed of a dense matrix product on this machine, floating-point operations per second. It is
/// measured with a product that takes a few milliseconds. Time predictions use it.
[[nodiscard]] double dense_flops_per_second();

} // namespace tactus::fem
