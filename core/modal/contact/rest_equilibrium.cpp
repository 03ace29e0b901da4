#include "core/modal/contact/rest_equilibrium.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
namespace {

using Rigid = RestEquilibrium::Rigid;

constexpr double kSameDirection = 1e-3; // relative: smaller remainders come from the mesh
constexpr double kBalance = 1e-6;       // share of the load

double dot(const Rigid& a, const Rigid& b) {
  double sum = 0;
  for (std::size_t r = 0; r < a.size(); ++r)
    sum += a[r] * b[r];
  return sum;
}

/// An orthonormal basis of the span, by Gram-Schmidt with pivoting.
std::vector<Rigid> span_of(std::vector<Rigid> gain) {
  std::vector<Rigid> basis;
  double longest = 0;
  for (const Rigid& g : gain)
    longest = std::max(longest, std::sqrt(dot(g, g)));
  while (true) {
    const auto longest_gain =
        std::max_element(gain.begin(), gain.end(),
                         [](const Rigid& a, const Rigid& b) { return dot(a, a) < dot(b, b); });
    const double length =
        longest_gain == gain.end() ? 0 : std::sqrt(dot(*longest_gain, *longest_gain));
    if (!(length > kSameDirection * longest))
      return basis;
    Rigid axis = *longest_gain;
    for (double& x : axis)
      x /= length;
    basis.push_back(axis);
    for (Rigid& g : gain) {
      const double along = dot(axis, g);
      for (std::size_t r = 0; r < g.size(); ++r)
        g[r] -= along * axis[r];
    }
  }
}

/// Solves the symmetric positive semidefinite system a x = right by Gauss-Jordan elimination; x is
/// 0 where a is singular.
std::vector<double> solve(std::vector<std::vector<double>> a, std::vector<double> right) {
  const std::size_t count = right.size();
  double largest = 0;
  for (std::size_t i = 0; i < count; ++i)
    largest = std::max(largest, a[i][i]);
  std::vector<double> x(count, 0);
  std::vector<bool> used(count, false);
  for (std::size_t round = 0; round < count; ++round) {
    std::size_t best = count;
    for (std::size_t i = 0; i < count; ++i)
      if (!used[i] && (best == count || a[i][i] > a[best][best]))
        best = i;
    if (!(a[best][best] > 1e-10 * largest))
      break;
    used[best] = true;
    for (std::size_t i = 0; i < count; ++i) {
      if (i == best)
        continue;
      const double ratio = a[i][best] / a[best][best];
      for (std::size_t j = 0; j < count; ++j)
        a[i][j] -= ratio * a[best][j];
      right[i] -= ratio * right[best];
    }
  }
  for (std::size_t i = 0; i < count; ++i)
    if (used[i])
      x[i] = right[i] / a[i][i];
  return x;
}

} // namespace

RestEquilibrium::RestEquilibrium(std::span<const Rigid> gain, const Rigid& load, double pressing_n)
    : force_n(gain.size(), 0), basis(span_of({gain.begin(), gain.end()})) {
  if (basis.empty()) { // held: the points carry only the pressing force
    std::fill(force_n.begin(), force_n.end(), pressing_n);
    return;
  }
  // In the basis: sum of F h = target.
  const std::size_t axes = basis.size();
  std::vector<std::vector<double>> h(gain.size(), std::vector<double>(axes, 0));
  std::vector<double> target(axes, 0);
  double size = 0;
  for (std::size_t r = 0; r < axes; ++r) {
    target[r] = -dot(basis[r], load);
    for (std::size_t i = 0; i < gain.size(); ++i) {
      h[i][r] = dot(basis[r], gain[i]);
      target[r] += pressing_n * h[i][r];
    }
    size += target[r] * target[r];
  }
  std::vector<bool> carries(gain.size(), true);
  while (true) {
    std::vector<std::vector<double>> matrix(axes, std::vector<double>(axes, 0));
    for (std::size_t i = 0; i < gain.size(); ++i)
      for (std::size_t r = 0; r < axes && carries[i]; ++r)
        for (std::size_t s = 0; s < axes; ++s)
          matrix[r][s] += h[i][r] * h[i][s];
    const std::vector<double> multiplier = solve(matrix, target);
    std::size_t lifted = gain.size();
    for (std::size_t i = 0; i < gain.size(); ++i) {
      force_n[i] = 0;
      for (std::size_t r = 0; r < axes && carries[i]; ++r)
        force_n[i] += h[i][r] * multiplier[r];
      if (force_n[i] < 0 && (lifted == gain.size() || force_n[i] < force_n[lifted]))
        lifted = i;
    }
    if (lifted == gain.size())
      break;
    carries[lifted] = false;
  }
  double residual = 0;
  for (std::size_t r = 0; r < axes; ++r) {
    double residual_component = target[r];
    for (std::size_t i = 0; i < gain.size(); ++i)
      residual_component -= force_n[i] * h[i][r];
    residual += residual_component * residual_component;
  }
  balanced = residual <= kBalance * kBalance * size;
}

} // namespace tactus::modal
