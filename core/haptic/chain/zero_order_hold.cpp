#include "core/haptic/chain/zero_order_hold.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tactus::haptic {
namespace {

using Matrix = std::array<std::array<double, 3>, 3>;

Matrix product(const Matrix& a, const Matrix& b) noexcept {
  Matrix c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k)
        c[i][j] += a[i][k] * b[k][j];
  return c;
}

/// exp(A) by scaling and squaring: A is halved until its norm is at most 1/4, then come a Taylor
/// sum of 14 terms (remainder 1e-20) and the squarings. The closed form would lose digits near
/// critical damping and for K near 0.
Matrix exponential(Matrix a) noexcept {
  double largest = 0;
  for (const auto& row : a)
    largest = std::max(largest, std::abs(row[0]) + std::abs(row[1]) + std::abs(row[2]));
  int halvings = 0;
  while (largest > 0.25 && halvings < 60) {
    largest *= 0.5;
    ++halvings;
  }
  const double scale = std::ldexp(1.0, -halvings);
  for (auto& row : a)
    for (double& entry : row)
      entry *= scale;
  const Matrix identity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  Matrix sum = identity;
  for (int term = 14; term > 0; --term) { // Horner: I + A/1 (I + A/2 (I + ...))
    sum = product(a, sum);
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        sum[i][j] = sum[i][j] / term + identity[i][j];
  }
  for (int i = 0; i < halvings; ++i)
    sum = product(sum, sum);
  return sum;
}

} // namespace

MassSpringDamperStep MassSpringDamperStep::of(double mass_kg, double stiffness_n_per_m,
                                              double damping_n_s_per_m, double period_s) noexcept {
  // State (x, T v, u T^2/M): all entries of the matrix are dimensionless.
  const double t = period_s;
  const double spring = stiffness_n_per_m * t * t / mass_kg;
  const double damper = damping_n_s_per_m * t / mass_kg;
  const Matrix e = exponential({{{0, 1, 0}, {-spring, -damper, 1}, {0, 0, 0}}});
  const double unit_x = t * t / mass_kg;
  return {e[0][0], e[0][1] * t, e[0][2] * unit_x, e[1][0] / t, e[1][1], e[1][2] * unit_x / t};
}

} // namespace tactus::haptic
