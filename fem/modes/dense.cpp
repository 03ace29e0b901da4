#include "fem/modes/dense.hpp"

#include "fem/mesh/mesh.hpp"

#include <algorithm>
#include <cblas.h>
#include <chrono>

extern "C" void dsyevd_(const char* wanted, const char* triangle, const int* n, double* matrix,
                        const int* leading, double* values, double* work, const int* work_size,
                        int* integers, const int* integers_size, int* info);

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
  Eigenpairs pairs{std::vector<double>(size), {matrix.begin(), matrix.end()}};
  const int n = static_cast<int>(size);
  const int work_size = 1 + 6 * n + 2 * n * n, integers_size = 3 + 5 * n;
  std::vector<double> work(static_cast<std::size_t>(work_size));
  std::vector<int> integers(static_cast<std::size_t>(integers_size));
  int info = 0;
  dsyevd_("V", "L", &n, pairs.vectors.data(), &n, pairs.values.data(), work.data(), &work_size,
          integers.data(), &integers_size, &info);
  if (info != 0)
    throw InputError(
        "the eigenvalues of a small matrix do not converge: check the mesh for distorted elements");
  return pairs;
}

double dense_flops_per_second() {
  constexpr std::size_t kSize = 512;
  const std::vector<double> a(kSize * kSize, 1.0), b(kSize * kSize, 1.0);
  std::vector<double> c(kSize * kSize, 0.0);
  double best = 1e30; // the first product includes the library's start-up
  for (int i = 0; i < 3; ++i) {
    const auto begin = std::chrono::steady_clock::now();
    add_product(1, {a, kSize}, {b, kSize}, c, kSize);
    best = std::min(
        best, std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count());
  }
  return 2.0 * kSize * kSize * kSize / best;
}

} // namespace tactus::fem
