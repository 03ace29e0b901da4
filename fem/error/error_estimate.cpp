#include "fem/error/error_estimate.hpp"

#include "fem/element/jacobian.hpp"
#include "fem/element/matrices.hpp"
#include "fem/element/quadrature.hpp"
#include "fem/error/enrichment.hpp"
#include "fem/error/singular.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr std::size_t kTogether = 8;
using Lanes = std::array<double, kTogether>;
constexpr std::size_t kMaxSteps = 12;
/// What V + W holds of the whole error: .95 or more of smooth modes, .6 at singular edges.
constexpr double kHeldShare = .8;

/// Shape and enriching functions at the quadrature points of a shape.
struct Tabulated {
  std::vector<ShapeValues> nodal, enriching;
  std::vector<double> weight;

  explicit Tabulated(Shape shape) {
    for (const QuadraturePoint& q : mass_points(shape)) {
      evaluate(shape, q.at, nodal.emplace_back());
      evaluate_enrichment(shape, q.at, enriching.emplace_back());
      weight.push_back(q.weight);
    }
  }
};

const Tabulated& tabulated(Shape shape) {
  static const std::array<Tabulated, 5> tables{Tabulated(Shape::tet4), Tabulated(Shape::tet10),
                                               Tabulated(Shape::hex8), Tabulated(Shape::hex20),
                                               Tabulated(Shape::wedge15)};
  return tables[static_cast<std::size_t>(shape)];
}

/// The element matrices of W, one after another in single precision, which is ample here: first
/// K_WV, then the lower blocks of K_WW, nine numbers a pair.
class EnrichedSystem {
public:
  EnrichedSystem(const Mesh& mesh, std::span<const Material> materials, const Matrices& matrices)
      : mesh_(mesh), held_nodes_(matrices.held), functions_(mesh, matrices.held) {
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

  [[nodiscard]] const Enrichment& functions() const noexcept { return functions_; }
  [[nodiscard]] std::size_t unknowns() const noexcept { return 3 * functions_.count; }

  /// y = K_WW x and down = K_VW x.
  void multiply(std::span<const Lanes> x, std::span<Lanes> y, std::span<Lanes> down) const;
  /// y -= K_WV x
  void subtract_coupling(std::span<const Lanes> x, std::span<Lanes> y) const;
  /// y = r: lambda M_WV u - K_WV u
  void residual(std::span<const Material> materials, std::span<const Lanes> u, const Lanes& lambda,
                std::span<Lanes> y) const;
  /// y = D^-1 x
  void precondition(std::span<const Lanes> x, std::span<Lanes> y) const;

private:
  void integrate(std::size_t index, const ElasticLaw& law);
  void invert_diagonal();
  [[nodiscard]] std::size_t unknown(std::size_t element, std::size_t function) const noexcept {
    return 3 * static_cast<std::size_t>(functions_.number[functions_.first[element] + function]);
  }
  [[nodiscard]] double sign(std::size_t element, std::size_t function) const noexcept {
    return functions_.sign[functions_.first[element] + function];
  }

  const Mesh& mesh_;
  std::span<const std::uint8_t> held_nodes_;
  Enrichment functions_;
  std::vector<std::size_t> at_;
  std::vector<float> blocks_;
  std::vector<double> diagonal_;
};

/// Rows of B' for the displacement component i: where the slopes x, y, z stand in Voigt's order.
constexpr std::array<std::array<std::array<std::size_t, 2>, 3>, 3> kStrain{
    {{{{0, 0}, {5, 1}, {4, 2}}}, {{{1, 1}, {5, 0}, {3, 2}}}, {{{2, 2}, {4, 0}, {3, 1}}}}};

/// k += w B_a' C B_b with the stresses of b, C B_b, given: [component][Voigt].
using Stresses = std::array<std::array<double, 6>, 3>;
Stresses stresses(const Vector3& g, const ElasticLaw& law, double weight) noexcept {
  Stresses s{};
  for (std::size_t j = 0; j < 3; ++j)
    for (const auto& [row, slope] : kStrain[j])
      for (std::size_t v = 0; v < 6; ++v)
        s[j][v] += weight * law.matrix[v][row] * g[static_cast<int>(slope)];
  return s;
}
void couple(const Vector3& g, const Stresses& s, double* k) noexcept {
  for (std::size_t j = 0; j < 3; ++j) {
    k[j] += g.x * s[j][0] + g.y * s[j][5] + g.z * s[j][4];
    k[3 + j] += g.y * s[j][1] + g.x * s[j][5] + g.z * s[j][3];
    k[6 + j] += g.z * s[j][2] + g.x * s[j][4] + g.y * s[j][3];
  }
}

void EnrichedSystem::integrate(std::size_t index, const ElasticLaw& law) {
  const Element& e = mesh_.elements[index];
  const Tabulated& table = tabulated(e.shape);
  const std::size_t w = enriching_functions(e.shape).size();
  const auto v = static_cast<std::size_t>(node_count(e.shape));
  const auto nodes = mesh_.nodes_of(e);
  static thread_local std::vector<double> sum;
  sum.assign(9 * (w * v + w * (w + 1) / 2), 0.0);
  std::array<Vector3, kMostNodes> nodal;
  std::array<Vector3, kMaxEnriching> enriching;
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
  // Stored as (b, a): row of b, column of a. Held rows and columns are empty.
  const auto held = [&](std::size_t a, std::size_t k) {
    return functions_.held[unknown(index, a) + k] != 0;
  };
  for (std::size_t a = 0; a < w; ++a) {
    for (std::size_t b = 0; b < v; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (held(a, k) || held_nodes_[3 * static_cast<std::size_t>(nodes[b]) + i])
            sum[9 * (a * v + b) + 3 * i + k] = 0;
    for (std::size_t b = 0; b <= a; ++b)
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (held(a, k) || held(b, i))
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
    std::array<Vector3, 3> row;
    for (std::size_t i = 0; i < 3; ++i) {
      if (functions_.held[3 * f + i])
        d[4 * i] = 1;
      row[i] = {d[3 * i], d[3 * i + 1], d[3 * i + 2]};
    }
    const Vector3 a = cross(row[1], row[2]), b = cross(row[2], row[0]), c = cross(row[0], row[1]);
    const double inverse = 1 / dot(row[0], a);
    for (int i = 0; i < 3; ++i) { // symmetric
      d[3 * i] = inverse * a[i];
      d[3 * i + 1] = inverse * b[i];
      d[3 * i + 2] = inverse * c[i];
    }
  }
}

/// to += K from, or its transpose.
void add_block(const float* k, const Lanes* from, Lanes* to, bool transposed) noexcept {
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j) {
      const double entry = transposed ? k[3 * j + i] : k[3 * i + j];
      for (std::size_t c = 0; c < kTogether; ++c)
        to[i][c] += entry * from[j][c];
    }
}

void EnrichedSystem::multiply(std::span<const Lanes> x, std::span<Lanes> y,
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

void EnrichedSystem::subtract_coupling(std::span<const Lanes> x, std::span<Lanes> y) const {
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
        for (std::size_t c = 0; c < kTogether; ++c)
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
    const Tabulated& table = tabulated(e.shape);
    const auto nodes = mesh_.nodes_of(e);
    const double density = materials[static_cast<std::size_t>(e.region)].density;
    std::array<double, kMostNodes * kMaxEnriching> mass{};
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
        if (functions_.held[row])
          continue;
        for (std::size_t b = 0; b < nodes.size(); ++b)
          for (std::size_t c = 0; c < kTogether; ++c)
            y[row][c] += sign(index, a) * mass[a * nodes.size() + b] * lambda[c] *
                         u[3 * static_cast<std::size_t>(nodes[b]) + i][c];
      }
  }
}

void EnrichedSystem::precondition(std::span<const Lanes> x, std::span<Lanes> y) const {
  for (std::size_t f = 0; f < functions_.count; ++f)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t c = 0; c < kTogether; ++c)
        y[3 * f + i][c] = diagonal_[9 * f + 3 * i] * x[3 * f][c] +
                          diagonal_[9 * f + 3 * i + 1] * x[3 * f + 1][c] +
                          diagonal_[9 * f + 3 * i + 2] * x[3 * f + 2][c];
}

Lanes inner(std::span<const Lanes> a, std::span<const Lanes> b) noexcept {
  Lanes sum{};
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t c = 0; c < kTogether; ++c)
      sum[c] += a[i][c] * b[i][c];
  return sum;
}

void spread(std::span<const double> columns, std::size_t n, std::size_t width,
            std::span<Lanes> out) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < kTogether; ++c)
      out[i][c] = c < width ? columns[c * n + i] : 0;
}

} // namespace

ErrorEstimate estimate_errors(const Mesh& mesh, std::span<const Material> materials,
                              const Matrices& matrices, ShiftedFactor& factor, const Modes& modes,
                              double settle, const Progress& progress) {
  const std::size_t n = matrices.dofs(), count = modes.frequency_hz.size();
  const EnrichedSystem system(mesh, materials, matrices);
  const std::size_t m = system.unknowns();
  ErrorEstimate estimate;
  estimate.relative.assign(count, 0.0);
  estimate.share.assign(count * mesh.elements.size() * 3, 0.0F);
  std::vector<Lanes> u(n), down(n), right(m), r(m), z(m), p(m), q(m), e(m);
  std::vector<double> flat(n * kTogether);
  std::vector<int> elements_of(system.functions().count, 0);
  for (const int f : system.functions().number)
    ++elements_of[static_cast<std::size_t>(f)];
  for (std::size_t begin = 0; begin < count; begin += kTogether) {
    const std::size_t width = std::min(kTogether, count - begin);
    Lanes lambda{};
    for (std::size_t c = 0; c < width; ++c)
      lambda[c] = std::pow(2 * std::numbers::pi * modes.frequency_hz[begin + c], 2);
    spread(std::span(modes.shapes).subspan(begin * n, width * n), n, width, u);
    system.residual(materials, u, lambda, right);
    r = right;
    std::fill(e.begin(), e.end(), Lanes{});
    system.precondition(r, z);
    p = z;
    Lanes rz = inner(r, z), eta{};
    for (std::size_t step = 0; step < kMaxSteps; ++step) {
      system.multiply(p, q, down);
      for (std::size_t i = 0; i < n; ++i)
        for (std::size_t c = 0; c < width; ++c)
          flat[c * n + i] = down[i][c];
      factor.solve(std::span(flat).first(n * width), flat, width);
      spread(flat, n, width, down);
      system.subtract_coupling(down, q);
      const Lanes pq = inner(p, q);
      Lanes alpha{}, beta{};
      bool done = true;
      for (std::size_t c = 0; c < width; ++c) {
        alpha[c] = pq[c] > 0 ? rz[c] / pq[c] : 0;
        eta[c] += alpha[c] * rz[c];
        done = done && alpha[c] * rz[c] <= settle * eta[c];
      }
      for (std::size_t i = 0; i < m; ++i)
        for (std::size_t c = 0; c < kTogether; ++c) {
          e[i][c] += alpha[c] * p[i][c];
          r[i][c] -= alpha[c] * q[i][c];
        }
      estimate.iterations = std::max(estimate.iterations, step + 1);
      if (done)
        break;
      system.precondition(r, z);
      const Lanes next = inner(r, z);
      for (std::size_t c = 0; c < width; ++c)
        beta[c] = rz[c] > 0 ? next[c] / rz[c] : 0;
      rz = next;
      for (std::size_t i = 0; i < m; ++i)
        for (std::size_t c = 0; c < kTogether; ++c)
          p[i][c] = z[i][c] + beta[c] * p[i][c];
    }
    for (std::size_t c = 0; c < width; ++c)
      estimate.relative[begin + c] = eta[c] / (2 * lambda[c] * kHeldShare);
    const Enrichment& w = system.functions();
    for (std::size_t element = 0; element < mesh.elements.size(); ++element) {
      const auto functions = enriching_functions(mesh.elements[element].shape);
      for (std::size_t a = 0; a < functions.size(); ++a) {
        const auto f = static_cast<std::size_t>(w.number[w.first[element] + a]);
        for (std::size_t c = 0; c < width; ++c) {
          double part = 0;
          for (std::size_t k = 0; k < 3; ++k)
            part += right[3 * f + k][c] * e[3 * f + k][c];
          part /= 2 * lambda[c] * kHeldShare * elements_of[f];
          float* to = &estimate.share[((begin + c) * mesh.elements.size() + element) * 3];
          for (std::size_t axis = 0; axis < 3; ++axis)
            to[axis] += static_cast<float>(part * functions[a].share[axis]);
        }
      }
    }
    if (progress)
      progress(static_cast<double>(begin + width) / static_cast<double>(count));
  }
  return estimate;
}

ErrorCells interval_errors(const Mesh& mesh, std::span<const std::uint8_t> held,
                           const ErrorEstimate& estimate, std::size_t intervals) {
  ErrorCells cells{{}, std::vector<double>(intervals, kSmoothOrder)};
  const auto singular = singular_elements(mesh, held);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int i : mesh.elements[e].interval)
      if (singular[e])
        cells.order[static_cast<std::size_t>(i)] = kSingularOrder;
  for (std::size_t k = 0; k < estimate.relative.size(); ++k) {
    std::vector<double>& sum = cells.share.emplace_back(intervals, 0.0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      for (std::size_t axis = 0; axis < 3; ++axis)
        sum[static_cast<std::size_t>(mesh.elements[e].interval[axis])] +=
            double(estimate.share[(k * mesh.elements.size() + e) * 3 + axis]);
  }
  return cells;
}

ErrorCells element_errors(const Mesh& mesh, std::span<const std::uint8_t> held,
                          const ErrorEstimate& estimate) {
  ErrorCells cells;
  for (const std::uint8_t singular : singular_elements(mesh, held))
    cells.order.push_back(singular ? kSingularOrder : kSmoothOrder);
  for (std::size_t k = 0; k < estimate.relative.size(); ++k)
    for (std::vector<double>& sum = cells.share.emplace_back();
         sum.size() < mesh.elements.size();) {
      const float* share = &estimate.share[(k * mesh.elements.size() + sum.size()) * 3];
      sum.push_back(double(share[0]) + double(share[1]) + double(share[2]));
    }
  return cells;
}

} // namespace tactus::fem
