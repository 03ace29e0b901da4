#include "fem/modes/dense.hpp"

#include <Eigen/Eigenvalues>
#include <cblas.h>

#include <algorithm>
#include <chrono>

namespace tactus::fem {

std::vector<double> transposed_product(std::span<const double> a, std::size_t p,
                                       std::span<const double> b, std::size_t q, std::size_t n) {
  std::vector<double> c(p * q, 0.0);
  const auto rows = static_cast<int>(n), pi = static_cast<int>(p), qi = static_cast<int>(q);
  if (p && q)
    cblas_dgemm(CblasColMajor, CblasTrans, CblasNoTrans, pi, qi, rows, 1, a.data(), rows, b.data(),
                rows, 0, c.data(), pi);
  return c;
}

void add_product(double factor, const Columns& a, const Columns& c, std::span<double> b,
                 std::size_t n) {
  const auto rows = static_cast<int>(n), p = static_cast<int>(a.count),
             q = static_cast<int>(c.count);
  if (p && q)
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, rows, q, p, factor, a.values.data(),
                rows, c.values.data(), p, 1, b.data(), rows);
}

Eigenpairs symmetric_eigenpairs(std::span<const double> matrix, std::size_t size) {
  const auto n = static_cast<Eigen::Index>(size);
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(
      Eigen::Map<const Eigen::MatrixXd>(matrix.data(), n, n));
  Eigenpairs pairs;
  pairs.values.assign(solver.eigenvalues().data(), solver.eigenvalues().data() + n);
  pairs.vectors.assign(solver.eigenvectors().data(), solver.eigenvectors().data() + n * n);
  return pairs;
}

double dense_flops_per_second() {
  constexpr std::size_t kSize = 512;
  const std::vector<double> a(kSize * kSize, 1.0), b(kSize * kSize, 1.0);
  std::vector<double> c(kSize * kSize, 0.0);
  double best = 1e30; // the first product also wakes the library up
  for (int i = 0; i < 3; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    add_product(1, {a, kSize}, {b, kSize}, c, kSize);
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return 2.0 * kSize * kSize * kSize / best;
}

} // namespace tactus::fem
