#include "fem/error/error_estimate.hpp"

#include "fem/error/enriched_system.hpp"
#include "fem/error/singular.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr std::size_t kMaxSteps = 20;
/// What V + W holds of an element's error: .8 to 1 where modes are smooth, half next to a
/// singular line.
constexpr double kEnrichedShareSmooth = .78, kEnrichedShareSingular = .5;
/// Steps of conjugate gradients add ever less; what the steps not done would have added is taken
/// to go on geometrically, by this ratio at most.
constexpr double kMaxRatio = .75;

Lanes inner(std::span<const Lanes> a, std::span<const Lanes> b) noexcept {
  Lanes sum{};
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t c = 0; c < kBlockColumns; ++c)
      sum[c] += a[i][c] * b[i][c];
  return sum;
}

void spread(std::span<const double> columns, std::size_t n, std::size_t width,
            std::span<Lanes> out) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < kBlockColumns; ++c)
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
  std::vector<double> flat(n * kBlockColumns);
  const std::vector<std::uint8_t> singular = singular_elements(mesh, matrices.constrained);
  std::vector<int> elements_of(system.functions().count, 0);
  for (const int f : system.functions().number)
    ++elements_of[static_cast<std::size_t>(f)];
  for (std::size_t begin = 0; begin < count; begin += kBlockColumns) {
    const std::size_t width = std::min(kBlockColumns, count - begin);
    Lanes lambda{};
    for (std::size_t c = 0; c < width; ++c)
      lambda[c] = std::pow(2 * std::numbers::pi * modes.frequency_hz[begin + c], 2);
    spread(std::span(modes.shapes).subspan(begin * n, width * n), n, width, u);
    system.residual(materials, u, lambda, right);
    r = right;
    std::fill(e.begin(), e.end(), Lanes{});
    system.precondition(r, z);
    p = z;
    Lanes rz = inner(r, z), eta{}, added{}, ratio{};
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
        ratio[c] = added[c] > 0 ? std::min(alpha[c] * rz[c] / added[c], kMaxRatio) : 0;
        added[c] = alpha[c] * rz[c];
        eta[c] += added[c];
        done = done && alpha[c] * rz[c] <= settle * eta[c];
      }
      for (std::size_t i = 0; i < m; ++i)
        for (std::size_t c = 0; c < kBlockColumns; ++c) {
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
        for (std::size_t c = 0; c < kBlockColumns; ++c)
          p[i][c] = z[i][c] + beta[c] * p[i][c];
    }
    Lanes scale{};
    for (std::size_t c = 0; c < width; ++c)
      if (eta[c] > 0)
        scale[c] = (1 + added[c] * ratio[c] / ((1 - ratio[c]) * eta[c])) / (2 * lambda[c]);
    const Enrichment& w = system.functions();
    for (std::size_t element = 0; element < mesh.elements.size(); ++element) {
      const auto functions = enriching_functions(mesh.elements[element].shape);
      for (std::size_t a = 0; a < functions.size(); ++a) {
        const auto f = static_cast<std::size_t>(w.number[w.first[element] + a]);
        for (std::size_t c = 0; c < width; ++c) {
          double part = 0;
          for (std::size_t k = 0; k < 3; ++k)
            part += right[3 * f + k][c] * e[3 * f + k][c];
          part *= scale[c] / (elements_of[f] *
                              (singular[element] ? kEnrichedShareSingular : kEnrichedShareSmooth));
          estimate.relative[begin + c] += part;
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

ErrorCells interval_errors(const Mesh& mesh, std::span<const std::uint8_t> constrained,
                           const ErrorEstimate& estimate, std::size_t intervals) {
  // An interval's order is the mean over its elements, by what they add to each mode's error.
  ErrorCells cells{{}, std::vector<double>(intervals, 0.0)};
  std::vector<double> weight(intervals, 1e-12);
  const auto singular = singular_axes(mesh, constrained);
  for (std::size_t k = 0; k < estimate.relative.size(); ++k) {
    std::vector<double>& sum = cells.share.emplace_back(intervals, 0.0);
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto i = static_cast<std::size_t>(mesh.elements[e].interval[axis]);
        const double part = double(estimate.share[(k * mesh.elements.size() + e) * 3 + axis]);
        sum[i] += part;
        const double of_mode = std::max(part, 0.0) / std::max(estimate.relative[k], 1e-300);
        weight[i] += of_mode;
        cells.order[i] += of_mode * (singular[e][axis] ? kSingularOrder : kSmoothOrder);
      }
  }
  for (std::size_t i = 0; i < intervals; ++i)
    cells.order[i] = (cells.order[i] + 1e-12 * kSmoothOrder) / weight[i];
  return cells;
}

ErrorCells element_errors(const Mesh& mesh, std::span<const std::uint8_t> constrained,
                          const ErrorEstimate& estimate) {
  ErrorCells cells;
  for (const std::uint8_t singular : singular_elements(mesh, constrained))
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
