#include "fem/error/enriched_system.hpp"

#include "fem/element/jacobian.hpp"
#include "fem/element/quadrature.hpp"
#include "fem/vector_clones.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// Shape and enriching functions at the quadrature points of a shape.
struct EnrichedShape {
  std::vector<ShapeValues> nodal, enriching;
  std::vector<double> weight;

  explicit EnrichedShape(Shape shape) {
    for (const QuadraturePoint& q : mass_points(shape)) {
      evaluate(shape, q.at, nodal.emplace_back());
      evaluate_enrichment(shape, q.at, enriching.emplace_back());
      weight.push_back(q.weight);
    }
  }
};

const EnrichedShape& enriched_shape(Shape shape) {
  static const auto tables = for_shapes([](Shape s) { return EnrichedShape(s); });
  return tables[static_cast<std::size_t>(shape)];
}

/// Rows of B' for the displacement component i: the index in Voigt order of the slopes x, y, z.
constexpr std::array<std::array<std::array<std::size_t, 2>, 3>, 3> kStrainRows{
    {{{{0, 0}, {5, 1}, {4, 2}}}, {{{1, 1}, {5, 0}, {3, 2}}}, {{{2, 2}, {4, 0}, {3, 1}}}}};

/// k += w B_a' C B_b with the stresses of b, C B_b, given: [component][Voigt].
using Stresses = std::array<std::array<double, 6>, 3>;
Stresses stresses(const Vec3& g, const ElasticLaw& law, double weight) noexcept {
  Stresses s{};
  for (std::size_t j = 0; j < 3; ++j)
    for (const auto& [row, slope] : kStrainRows[j])
      for (std::size_t v = 0; v < 6; ++v)
        s[j][v] += weight * law.matrix[v][row] * g[static_cast<int>(slope)];
  return s;
}
void couple(const Vec3& g, const Stresses& s, double* k) noexcept {
  for (std::size_t j = 0; j < 3; ++j) {
    k[j] += g.x * s[j][0] + g.y * s[j][5] + g.z * s[j][4];
    k[3 + j] += g.y * s[j][1] + g.x * s[j][5] + g.z * s[j][3];
    k[6 + j] += g.z * s[j][2] + g.x * s[j][4] + g.y * s[j][3];
  }
}

/// to += K from, or its transpose.
inline void add_block(const float* k, const Lanes* from, Lanes* to, bool transposed) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double entry = transposed ? k[3 * j + i] : k[3 * i + j];
      for (std::size_t c = 0; c < kBlockColumns; ++c)
        to[i][c] += entry * from[j][c];
    }
}

} // namespace

EnrichedSystem::EnrichedSystem(const Mesh& mesh, std::span<const Material> materials,
                               const Matrices& matrices)
    : mesh_(mesh), constrained_nodes_(matrices.constrained),
      functions_(mesh, matrices.constrained) {
  const std::vector<ElasticLaw> laws(materials.begin(), materials.end());
  std::size_t size = 0;
  for (const Element& e : mesh.elements) {
    at_.push_back(size);
    const auto w = enriching_functions(e.shape).size();
    const auto v = static_cast<std::size_t>(node_count(e.shape));
    size += 9 * (w * v + w * (w + 1) / 2);
  }
  blocks_.assign(size, 0);
  diagonal_.assign(9 * functions_.count, 0.0);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    integrate(e, laws[static_cast<std::size_t>(mesh.elements[e].region)]);
  invert_diagonal();
}

void EnrichedSystem::integrate(std::size_t index, const ElasticLaw& law) {
  const Element& e = mesh_.elements[index];
  const EnrichedShape& table = enriched_shape(e.shape);
  const std::size_t w = enriching_functions(e.shape).size();
  const auto v = static_cast<std::size_t>(node_count(e.shape));
  const auto nodes = mesh_.nodes_of(e);
  static thread_local std::vector<double> sum;
  sum.assign(9 * (w * v + w * (w + 1) / 2), 0.0);
  std::array<Vec3, kMaxNodes> nodal;
  std::array<Vec3, kMaxEnriching> enriching;
  for (std::size_t q = 0; q < table.weight.size(); ++q) {
    const Jacobian j = jacobian(mesh_, e, table.nodal[q]);
    for (std::size_t a = 0; a < v; ++a)
      nodal[a] = j.to_space(table.nodal[q].derivative[a]);
    for (std::size_t a = 0; a < w; ++a)
      enriching[a] = sign(index, a) * j.to_space(table.enriching[q].derivative[a]);
    const double weight = table.weight[q] * j.determinant;
    // B_a' C B_b for all b at once, from the stresses of a: the transposed block.
    for (std::size_t a = 0; a < w; ++a) {
      const Stresses s = stresses(enriching[a], law, weight);
      for (std::size_t b = 0; b < v; ++b)
        couple(nodal[b], s, &sum[9 * (a * v + b)]);
      for (std::size_t b = 0; b <= a; ++b)
        couple(enriching[b], s, &sum[9 * (w * v + a * (a + 1) / 2 + b)]);
    }
  }
  // Stored as (b, a), with the row of b and the column of a. Constrained rows and columns are
  // empty.
  const auto constrained = [&](std::size_t a, std::size_t k) {
    return functions_.constrained[unknown(index, a) + k] != 0;
  };
  for (std::size_t a = 0; a < w; ++a) {
    for (std::size_t b = 0; b < v; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (constrained(a, k) || constrained_nodes_[3 * static_cast<std::size_t>(nodes[b]) + i])
            sum[9 * (a * v + b) + 3 * i + k] = 0;
    for (std::size_t b = 0; b <= a; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (constrained(a, k) || constrained(b, i))
            sum[9 * (w * v + a * (a + 1) / 2 + b) + 3 * i + k] = 0;
    for (std::size_t i = 0; i < 9; ++i)
      diagonal_[3 * unknown(index, a) + i] += sum[9 * (w * v + a * (a + 1) / 2 + a) + i];
  }
  std::transform(sum.begin(), sum.end(), blocks_.begin() + static_cast<std::ptrdiff_t>(at_[index]),
                 [](double x) { return static_cast<float>(x); });
}

void EnrichedSystem::invert_diagonal() {
  for (std::size_t f = 0; f < functions_.count; ++f) {
    double* d = &diagonal_[9 * f];
    std::array<Vec3, 3> row;
    for (std::size_t i = 0; i < 3; ++i) {
      if (functions_.constrained[3 * f + i])
        d[4 * i] = 1;
      row[i] = {d[3 * i], d[3 * i + 1], d[3 * i + 2]};
    }
    const Vec3 a = cross(row[1], row[2]), b = cross(row[2], row[0]), c = cross(row[0], row[1]);
    const double inverse = 1 / dot(row[0], a);
    for (int i = 0; i < 3; ++i) { // symmetric
      d[3 * i] = inverse * a[i];
      d[3 * i + 1] = inverse * b[i];
      d[3 * i + 2] = inverse * c[i];
    }
  }
}

TACTUS_VECTOR_CLONES void EnrichedSystem::multiply(std::span<const Lanes> x, std::span<Lanes> y,
                                                   std::span<Lanes> down) const {
  std::fill(y.begin(), y.end(), Lanes{});
  std::fill(down.begin(), down.end(), Lanes{});
  for (std::size_t e = 0; e < mesh_.elements.size(); ++e) {
    const auto nodes = mesh_.nodes_of(mesh_.elements[e]);
    const std::size_t w = functions_.first[e + 1] - functions_.first[e], v = nodes.size();
    const float* k = &blocks_[at_[e]];
    for (std::size_t a = 0; a < w; ++a)
      for (std::size_t b = 0; b < v; ++b, k += 9)
        add_block(k, &x[unknown(e, a)], &down[3 * static_cast<std::size_t>(nodes[b])], false);
    for (std::size_t a = 0; a < w; ++a)
      for (std::size_t b = 0; b <= a; ++b, k += 9) {
        add_block(k, &x[unknown(e, a)], &y[unknown(e, b)], false);
        if (b != a)
          add_block(k, &x[unknown(e, b)], &y[unknown(e, a)], true);
      }
  }
}

TACTUS_VECTOR_CLONES void EnrichedSystem::subtract_coupling(std::span<const Lanes> x,
                                                            std::span<Lanes> y) const {
  std::array<Lanes, 3> sum;
  for (std::size_t e = 0; e < mesh_.elements.size(); ++e) {
    const auto nodes = mesh_.nodes_of(mesh_.elements[e]);
    const std::size_t w = functions_.first[e + 1] - functions_.first[e], v = nodes.size();
    const float* k = &blocks_[at_[e]];
    for (std::size_t a = 0; a < w; ++a) {
      sum = {};
      for (std::size_t b = 0; b < v; ++b, k += 9)
        add_block(k, &x[3 * static_cast<std::size_t>(nodes[b])], sum.data(), true);
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t c = 0; c < kBlockColumns; ++c)
          y[unknown(e, a) + i][c] -= sum[i][c];
    }
  }
}

void EnrichedSystem::residual(std::span<const Material> materials, std::span<const Lanes> u,
                              const Lanes& lambda, std::span<Lanes> y) const {
  std::fill(y.begin(), y.end(), Lanes{});
  subtract_coupling(u, y);
  for (std::size_t index = 0; index < mesh_.elements.size(); ++index) {
    const Element& e = mesh_.elements[index];
    const EnrichedShape& table = enriched_shape(e.shape);
    const auto nodes = mesh_.nodes_of(e);
    const double density = materials[static_cast<std::size_t>(e.region)].density;
    std::array<double, kMaxNodes * kMaxEnriching> mass{};
    const std::size_t w = functions_.first[index + 1] - functions_.first[index];
    for (std::size_t q = 0; q < table.weight.size(); ++q) {
      const double weight =
          density * table.weight[q] * jacobian(mesh_, e, table.nodal[q]).determinant;
      for (std::size_t a = 0; a < w; ++a)
        for (std::size_t b = 0; b < nodes.size(); ++b)
          mass[a * nodes.size() + b] +=
              weight * table.enriching[q].value[a] * table.nodal[q].value[b];
    }
    for (std::size_t a = 0; a < w; ++a)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::size_t row = unknown(index, a) + i;
        if (functions_.constrained[row])
          continue;
        for (std::size_t b = 0; b < nodes.size(); ++b)
          for (std::size_t c = 0; c < kBlockColumns; ++c)
            y[row][c] += sign(index, a) * mass[a * nodes.size() + b] * lambda[c] *
                         u[3 * static_cast<std::size_t>(nodes[b]) + i][c];
      }
  }
}

TACTUS_VECTOR_CLONES void EnrichedSystem::precondition(std::span<const Lanes> x,
                                                       std::span<Lanes> y) const {
  for (std::size_t f = 0; f < functions_.count; ++f)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < kBlockColumns; ++c)
        y[3 * f + i][c] = diagonal_[9 * f + 3 * i] * x[3 * f][c] +
                          diagonal_[9 * f + 3 * i + 1] * x[3 * f + 1][c] +
                          diagonal_[9 * f + 3 * i + 2] * x[3 * f + 2][c];
}

} // namespace tactus::fem
