#include "fem/small_dense.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

extern "C" {
void dposv_(const char* triangle, const int* n, const int* columns, double* matrix,
            const int* leading, double* right, const int* leading_right, int* info);
void dgesv_(const int* n, const int* columns, double* matrix, const int* leading, int* pivots,
            double* right, const int* leading_right, int* info);
void dgelsy_(const int* rows, const int* columns, const int* right_columns, double* matrix,
             const int* leading, double* right, const int* leading_right, int* pivots,
             const double* condition, int* rank, double* work, const int* work_size, int* info);
}

namespace tactus::fem {

bool solve_positive_definite(std::vector<double> a, std::span<double> right, std::size_t size) {
  const int n = static_cast<int>(size), columns = static_cast<int>(right.size() / size);
  int info = 0;
  dposv_("L", &n, &columns, a.data(), &n, right.data(), &n, &info);
  return info == 0;
}

bool solve_regular(std::vector<double> a, std::span<double> right, std::size_t size) {
  const int n = static_cast<int>(size), columns = static_cast<int>(right.size() / size);
  std::vector<int> pivots(size);
  int info = 0;
  dgesv_(&n, &columns, a.data(), &n, pivots.data(), right.data(), &n, &info);
  return info == 0;
}

std::vector<double> solve_of_any_rank(std::vector<double> a, std::span<const double> right) {
  std::vector<double> x(right.begin(), right.end());
  const int n = static_cast<int>(x.size()), one = 1;
  // Relative size of a linearly dependent column after rounding.
  const double condition = static_cast<double>(n) * std::numeric_limits<double>::epsilon();
  std::vector<int> pivots(x.size(), 0);
  int rank = 0, info = 0, work_size = 67 * (n + 1);
  std::vector<double> work(static_cast<std::size_t>(work_size));
  dgelsy_(&n, &n, &one, a.data(), &n, x.data(), &n, pivots.data(), &condition, &rank, work.data(),
          &work_size, &info);
  return x;
}

Eigenpairs3 symmetric_eigenpairs(const std::array<Vec3, 3>& rows) noexcept {
  std::array<Vec3, 3> a = rows, axis{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  const auto at = [&](int i, int j) -> double& { return a[static_cast<std::size_t>(i)][j]; };
  for (int sweep = 0; sweep < 30; ++sweep) { // six sweeps are enough; the bound ends the loop even
                                             // with NaN
    const double off = std::abs(at(0, 1)) + std::abs(at(0, 2)) + std::abs(at(1, 2));
    const double size = std::abs(at(0, 0)) + std::abs(at(1, 1)) + std::abs(at(2, 2));
    if (!(off > 1e-17 * size))
      break;
    for (const auto& [p, q] : {std::pair(0, 1), {0, 2}, {1, 2}}) {
      if (at(p, q) == 0)
        continue;
      // The smaller of the two angles that make a_pq vanish (Golub & Van Loan, 8.5).
      const double tau = (at(q, q) - at(p, p)) / (2 * at(p, q));
      const double tangent = (tau >= 0 ? 1 : -1) / (std::abs(tau) + std::sqrt(1 + tau * tau));
      const double c = 1 / std::sqrt(1 + tangent * tangent), s = tangent * c;
      const int r = 3 - p - q;
      const double pr = at(p, r), qr = at(q, r), turned = tangent * at(p, q);
      at(p, p) -= turned;
      at(q, q) += turned;
      at(p, q) = at(q, p) = 0;
      at(p, r) = at(r, p) = c * pr - s * qr;
      at(q, r) = at(r, q) = s * pr + c * qr;
      Vec3 &one = axis[static_cast<std::size_t>(p)], &other = axis[static_cast<std::size_t>(q)];
      const Vec3 before = one;
      one = c * before - s * other;
      other = s * before + c * other;
    }
  }
  std::array<std::size_t, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) {
    return a[i][static_cast<int>(i)] < a[j][static_cast<int>(j)];
  });
  Eigenpairs3 pairs;
  for (std::size_t k = 0; k < 3; ++k) {
    pairs.values[k] = a[order[k]][static_cast<int>(order[k])];
    pairs.vectors[k] = axis[order[k]];
  }
  return pairs;
}

} // namespace tactus::fem
