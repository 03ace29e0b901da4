#include "fem/design/past_solutions.hpp"

#include "fem/modes/dense.hpp"
#include "fem/small_dense.hpp"

#include <algorithm>
#include <cblas.h>
#include <cmath>

namespace tactus::fem {
namespace {

/// Relative norm below which a solution, orthogonalised to the newer ones, is only rounding error.
constexpr double kMinRemainder = 1e-9;

double inner_product(std::span<const double> a, std::span<const double> b) {
  return cblas_ddot(static_cast<blasint>(a.size()), a.data(), 1, b.data(), 1);
}

} // namespace

void PastSolutions::add(std::span<const double> u) {
  // A repeated solution of the same shape adds nothing and would replace a useful one.
  if (!kept_.empty() && kept_[0].size() == u.size()) {
    double change = 0;
    for (std::size_t i = 0; i < u.size(); ++i)
      change += (u[i] - kept_[0][i]) * (u[i] - kept_[0][i]);
    if (!(std::sqrt(change) > kMinRemainder * std::sqrt(inner_product(u, u))))
      kept_.erase(kept_.begin());
  }
  kept_.insert(kept_.begin(), std::vector(u.begin(), u.end()));
  if (kept_.size() > max_count_)
    kept_.pop_back();
}

void PastSolutions::start(const Matrices& m, std::span<const double> b, std::span<double> x) const {
  std::fill(x.begin(), x.end(), 0.0);
  // Orthonormal basis by Gram-Schmidt, applied twice, since successive solutions of a drag differ
  // little.
  const std::size_t n = b.size();
  std::vector<double> basis;
  std::size_t count = 0;
  for (const std::vector<double>& u : kept_) {
    if (u.size() != n)
      continue;
    std::vector<double> own = u;
    const double size = std::sqrt(inner_product(own, own));
    for (int pass = 0; pass < 2; ++pass)
      for (std::size_t k = 0; k < count; ++k) {
        const auto other = std::span(basis).subspan(k * n, n);
        const double share = inner_product(other, own);
        for (std::size_t i = 0; i < n; ++i)
          own[i] -= share * other[i];
      }
    const double left = std::sqrt(inner_product(own, own));
    if (!(left > kMinRemainder * size))
      continue;
    for (double& value : own)
      value /= left;
    basis.insert(basis.end(), own.begin(), own.end());
    ++count;
  }
  if (count == 0)
    return;
  std::vector<double> image(basis.size());
  m.multiply_stiffness(basis, image, count);
  std::vector<double> weight = transposed_product(basis, count, b, 1, n);
  if (solve_positive_definite(transposed_product(basis, count, image, count, n), weight, count))
    add_product(1, {basis, count}, {weight, 1}, x, n);
}

double PastSolutions::bytes() const noexcept {
  double sum = 0;
  for (const std::vector<double>& u : kept_)
    sum += 8. * static_cast<double>(u.size());
  return sum;
}

} // namespace tactus::fem
