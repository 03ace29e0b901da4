#include "fem/element/matrices.hpp"

#include "fem/element/tabulated.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// sum over the quadrature points of w dV (grad N_a)_i (grad N_b)_j: all shape data that an
/// element's stiffness needs. The products of one node a with all nodes b: [3 i + j][b].
using OuterProducts = std::array<std::array<double, kMaxNodes>, 9>;

constexpr std::size_t kMaxStiffnessPoints = 27; ///< the number of hex20

/// Slopes of all nodes at a point, by direction.
using Slopes = std::array<std::array<double, kMaxNodes>, 3>;

/// K_ab = lambda D + mu (D' + tr D), D = sum w grad N_a (grad N_b)'.
void isotropic_block(const std::array<double, 9>& d, double lambda, double mu, double* k) {
  const double trace = mu * (d[0] + d[4] + d[8]);
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      k[3 * i + j] = lambda * d[3 * i + j] + mu * d[3 * j + i] + (i == j ? trace : 0);
}

/// Rows of B' for the displacement component i: the index in Voigt order of the slopes x, y, z.
constexpr std::array<std::array<std::size_t, 3>, 3> kStrain{{{0, 5, 4}, {5, 1, 3}, {4, 3, 2}}};

/// (K_ab)_ij = sum over k, l of C_(ik)(jl) D_kl.
void general_block(const std::array<double, 9>& d, const ElasticMatrix& c, double* out) {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t l = 0; l < 3; ++l)
          sum += c[kStrain[i][k]][kStrain[j][l]] * d[3 * k + l];
      out[3 * i + j] = sum;
    }
}

} // namespace

ElasticLaw::ElasticLaw(const Material& m)
    : isotropic(m.isotropic()), density(m.density), matrix(elastic_matrix(m)) {
  const double e = m.young_pa[0], nu = m.poisson[0];
  if (isotropic) {
    lame_lambda = e * nu / ((1 + nu) * (1 - 2 * nu));
    lame_mu = e / (2 * (1 + nu));
  }
}

void element_stiffness(const Mesh& mesh, const Element& e, const ElasticLaw& law,
                       StiffnessBlocks& out) {
  const auto n = static_cast<std::size_t>(node_count(e.shape));
  const Tabulated& table = at_stiffness_points(e.shape);
  std::array<Slopes, kMaxStiffnessPoints> slopes, weighted;
  PointGradients at;
  const std::size_t points = table.weights.size();
  for (std::size_t q = 0; q < points; ++q) {
    gradients(mesh, e, table.values[q], at);
    const double weight = table.weights[q] * at.determinant;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t i = 0; i < 3; ++i) {
        slopes[q][i][a] = at.slope[a][static_cast<int>(i)];
        weighted[q][i][a] = weight * slopes[q][i][a];
      }
  }
  OuterProducts d;
  std::array<double, 9> own;
  for (std::size_t a = 0; a < n; ++a) {
    for (auto& row : d)
      std::fill_n(row.begin(), a + 1, 0.0);
    for (std::size_t q = 0; q < points; ++q)
      for (std::size_t i = 0; i < 3; ++i) {
        const double slope = weighted[q][i][a];
        for (std::size_t j = 0; j < 3; ++j)
          for (std::size_t b = 0; b <= a; ++b)
            d[3 * i + j][b] += slope * slopes[q][j][b];
      }
    for (std::size_t b = 0; b <= a; ++b) {
      for (std::size_t k = 0; k < 9; ++k)
        own[k] = d[k][b];
      double* to = &out[9 * (a * n + b)];
      if (law.isotropic)
        isotropic_block(own, law.lame_lambda, law.lame_mu, to);
      else
        general_block(own, law.matrix, to);
    }
  }
}

void element_mass(const Mesh& mesh, const Element& e, double density, MassEntries& out) {
  const auto n = static_cast<std::size_t>(node_count(e.shape));
  std::fill_n(out.begin(), n * n, 0.0);
  const Tabulated& table = at_mass_points(e.shape);
  for (std::size_t q = 0; q < table.weights.size(); ++q) {
    const ShapeValues& values = table.values[q];
    const double weight = density * table.weights[q] * jacobian(mesh, e, values).determinant;
    for (std::size_t a = 0; a < n; ++a)
      for (std::size_t b = 0; b <= a; ++b)
        out[a * n + b] += weight * values.value[a] * values.value[b];
  }
}

} // namespace tactus::fem
