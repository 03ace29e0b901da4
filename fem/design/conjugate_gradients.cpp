#include "fem/design/conjugate_gradients.hpp"

#include "fem/modes/dense.hpp"
#include "fem/small_dense.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

double dot(std::span<const double> a, std::span<const double> b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += a[i] * b[i];
  return sum;
}

/// Ratio of the largest to the smallest eigenvalue of the Lanczos matrix that follows from the
/// coefficients.
double condition_of(std::span<const double> alpha, std::span<const double> beta) {
  const std::size_t n = alpha.size();
  if (n == 0)
    return 1;
  std::vector<double> t(n * n, 0.0);
  for (std::size_t k = 0; k < n; ++k) {
    t[k * n + k] = 1 / alpha[k] + (k > 0 ? beta[k - 1] / alpha[k - 1] : 0);
    if (k + 1 < n)
      t[k * n + k + 1] = t[(k + 1) * n + k] = std::sqrt(beta[k]) / alpha[k];
  }
  const Eigenpairs pairs = symmetric_eigenpairs(t, n);
  return pairs.values.back() / pairs.values.front();
}

} // namespace

CgReport conjugate_gradients(const Matrices& m, ShiftedFactor& preconditioner,
                             std::span<const double> b, std::span<double> x, double tolerance,
                             int max_iterations) {
  const std::size_t n = b.size();
  std::vector<double> r(n), z(n), p(n), image(n), before(n), alpha, beta;
  const double size = std::sqrt(dot(b, b));
  m.multiply_stiffness(x, image, 1);
  for (std::size_t i = 0; i < n; ++i)
    r[i] = m.constrained[i] ? 0 : b[i] - image[i];
  CgReport report;
  const auto residual = [&] {
    const double own = std::sqrt(dot(r, r));
    return size > 0 ? own / size : own;
  };
  double rz = 0;
  for (;;) {
    report.residual = residual();
    report.converged = report.residual <= tolerance;
    if (report.converged || report.iterations >= max_iterations)
      break;
    preconditioner.precondition(r, z);
    const double next = dot(r, z);
    if (!(next > 0))
      break;
    // Polak and Ribiere's form: with a preconditioner in single precision, the previous r' z does
    // not vanish, and the usual form needs more steps (Notay 2000).
    const double beta_step = report.iterations > 0 ? (next - dot(before, z)) / rz : 0;
    if (report.iterations > 0)
      beta.push_back(std::max(beta_step, 0.0));
    for (std::size_t i = 0; i < n; ++i)
      p[i] = z[i] + beta_step * p[i];
    before = r;
    rz = next;
    m.multiply_stiffness(p, image, 1);
    const double curvature = dot(p, image);
    if (!(curvature > 0)) // rounding, or a broken matrix
      break;
    alpha.push_back(rz / curvature);
    for (std::size_t i = 0; i < n; ++i) {
      x[i] += alpha.back() * p[i];
      r[i] -= alpha.back() * image[i];
    }
    ++report.iterations;
  }
  report.condition = condition_of(alpha, beta);
  return report;
}

double combined_approximations(const Matrices& m, ShiftedFactor& old_factor,
                               std::span<const double> b, std::span<double> x,
                               std::size_t vectors) {
  const std::size_t n = b.size();
  std::vector<double> basis(vectors * n), image(vectors * n), change(n);
  old_factor.solve(b, std::span(basis).first(n), 1);
  for (std::size_t k = 0; k < vectors; ++k) {
    const auto own = std::span(basis).subspan(k * n, n);
    // The smaller the change of K, the shorter the vectors. They are scaled to unit length so that
    // the small system is well conditioned.
    const double size = std::sqrt(dot(own, own));
    for (double& value : own)
      value = size > 0 ? value / size : 0;
    const auto its_image = std::span(image).subspan(k * n, n);
    m.multiply_stiffness(own, its_image, 1);
    if (k + 1 == vectors)
      break;
    old_factor.solve(its_image, change, 1);
    for (std::size_t i = 0; i < n; ++i)
      basis[(k + 1) * n + i] = own[i] - change[i];
  }
  // If K is unchanged, only the first vector remains, so the solver determines the rank.
  const std::vector<double> weight =
      solve_of_any_rank(transposed_product(basis, vectors, image, vectors, n),
                        transposed_product(basis, vectors, b, 1, n));
  double squares = 0;
  for (std::size_t i = 0; i < n; ++i) {
    double sum = 0, force = 0;
    for (std::size_t k = 0; k < vectors; ++k) {
      sum += weight[k] * basis[k * n + i];
      force += weight[k] * image[k * n + i];
    }
    x[i] = sum;
    squares += m.constrained[i] ? 0 : (b[i] - force) * (b[i] - force);
  }
  const double size = std::sqrt(dot(b, b));
  return size > 0 ? std::sqrt(squares) / size : 0;
}

} // namespace tactus::fem
