#pragma once
#include "fem/element/matrices.hpp"
#include "fem/element/tabulated.hpp"

namespace tactus::fem {

/// A 3 x 3 tensor, [row][column].
using Tensor = std::array<std::array<double, 3>, 3>;

/// The gradient of a field of nodal vectors, H_ij = sum_a u_a,i dN_a/dx_j; u has 3 numbers per node
/// of the element.
[[nodiscard]] inline Tensor field_gradient(const PointGradients& at, std::span<const double> u,
                                           std::size_t nodes) noexcept {
  Tensor h{};
  for (std::size_t a = 0; a < nodes; ++a)
    for (std::size_t i = 0; i < 3; ++i) {
      const double value = u[3 * a + i];
      h[i][0] += value * at.slope[a].x;
      h[i][1] += value * at.slope[a].y;
      h[i][2] += value * at.slope[a].z;
    }
  return h;
}

/// sigma = C sym(H), Voigt order xx yy zz yz xz xy.
[[nodiscard]] inline std::array<double, 6> stress_of(const ElasticLaw& law,
                                                     const Tensor& h) noexcept {
  const std::array<double, 6> strain{h[0][0],           h[1][1],           h[2][2],
                                     h[1][2] + h[2][1], h[0][2] + h[2][0], h[0][1] + h[1][0]};
  if (law.isotropic) {
    const double mean = law.lame_lambda * (strain[0] + strain[1] + strain[2]);
    const double mu = law.lame_mu;
    return {mean + 2 * mu * strain[0],
            mean + 2 * mu * strain[1],
            mean + 2 * mu * strain[2],
            mu * strain[3],
            mu * strain[4],
            mu * strain[5]};
  }
  std::array<double, 6> stress{};
  for (std::size_t v = 0; v < 6; ++v)
    for (std::size_t w = 0; w < 6; ++w)
      stress[v] += law.matrix[v][w] * strain[w];
  return stress;
}

[[nodiscard]] inline Tensor to_tensor(const std::array<double, 6>& s) noexcept {
  return {{{s[0], s[5], s[4]}, {s[5], s[1], s[3]}, {s[4], s[3], s[2]}}};
}

[[nodiscard]] inline Tensor operator*(const Tensor& a, const Tensor& b) noexcept {
  Tensor c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      c[i][j] = a[i][0] * b[0][j] + a[i][1] * b[1][j] + a[i][2] * b[2][j];
  return c;
}

/// A' B.
[[nodiscard]] inline Tensor transposed_product(const Tensor& a, const Tensor& b) noexcept {
  Tensor c{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      c[i][j] = a[0][i] * b[0][j] + a[1][i] * b[1][j] + a[2][i] * b[2][j];
  return c;
}

/// A : B.
[[nodiscard]] inline double contraction(const Tensor& a, const Tensor& b) noexcept {
  double sum = 0;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      sum += a[i][j] * b[i][j];
  return sum;
}

[[nodiscard]] inline double trace(const Tensor& a) noexcept { return a[0][0] + a[1][1] + a[2][2]; }

/// Nodal vectors of an element, taken from a vector of all degrees of freedom.
using ElementField = std::array<double, 3 * kMaxNodes>;
[[nodiscard]] inline ElementField gather(std::span<const double> u,
                                         std::span<const int> nodes) noexcept {
  ElementField own;
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t i = 0; i < 3; ++i)
      own[3 * a + i] = u[3 * static_cast<std::size_t>(nodes[a]) + i];
  return own;
}

} // namespace tactus::fem
