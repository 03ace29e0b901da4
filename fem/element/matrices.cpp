#include "fem/element/matrices.hpp"

#include "fem/element/tabulated.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

using Slopes = std::array<Vector3, kMostNodes>;

void add_isotropic(const Slopes& g, std::size_t n, double lambda, double mu, StiffnessBlocks& out) {
  for (std::size_t a = 0; a < n; ++a) {
    const Vector3 la = lambda * g[a], ma = mu * g[a];
    for (std::size_t b = 0; b <= a; ++b) {
      double* k = &out[9 * (a * n + b)];
      const Vector3& gb = g[b];
      const double d = dot(ma, gb);
      k[0] += la.x * gb.x + ma.x * gb.x + d;
      k[1] += la.x * gb.y + ma.y * gb.x;
      k[2] += la.x * gb.z + ma.z * gb.x;
      k[3] += la.y * gb.x + ma.x * gb.y;
      k[4] += la.y * gb.y + ma.y * gb.y + d;
      k[5] += la.y * gb.z + ma.z * gb.y;
      k[6] += la.z * gb.x + ma.x * gb.z;
      k[7] += la.z * gb.y + ma.y * gb.z;
      k[8] += la.z * gb.z + ma.z * gb.z + d;
    }
  }
}

/// Rows of B' for the displacement component i: where the slopes x, y, z stand in Voigt's order.
constexpr std::array<std::array<std::array<int, 2>, 3>, 3> kStrain{
    {{{{0, 0}, {5, 1}, {4, 2}}}, {{{1, 1}, {5, 0}, {3, 2}}}, {{{2, 2}, {4, 0}, {3, 1}}}}};

void add_general(const Slopes& g, std::size_t n, double weight, const ElasticMatrix& c,
                 StiffnessBlocks& out) {
  for (std::size_t b = 0; b < n; ++b) {
    std::array<std::array<double, 6>, 3> stress{}; // C B_b, a column for each component
    for (std::size_t j = 0; j < 3; ++j)
      for (const auto& [row, slope] : kStrain[j])
        for (std::size_t v = 0; v < 6; ++v)
          stress[j][v] += weight * c[v][static_cast<std::size_t>(row)] * g[b][slope];
    for (std::size_t a = b; a < n; ++a)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
          double sum = 0;
          for (const auto& [row, slope] : kStrain[i])
            sum += g[a][slope] * stress[j][static_cast<std::size_t>(row)];
          out[9 * (a * n + b) + 3 * i + j] += sum;
        }
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
  std::fill_n(out.begin(), 9 * n * n, 0.0);
  const Tabulated& table = at_stiffness_points(e.shape);
  PointGradients at;
  for (std::size_t q = 0; q < table.weights.size(); ++q) {
    gradients(mesh, e, table.values[q], at);
    const double weight = table.weights[q] * at.determinant;
    if (law.isotropic)
      add_isotropic(at.slope, n, weight * law.lame_lambda, weight * law.lame_mu, out);
    else
      add_general(at.slope, n, weight, law.matrix, out);
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
