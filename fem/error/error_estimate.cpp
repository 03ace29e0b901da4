#include "fem/error/error_estimate.hpp"

#include "fem/error/enriched_system.hpp"
#include "fem/error/singular.hpp"

#include <algorithm>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr std::size_t kMaxSteps = 20;
/// Fraction of an element's error that V + W contains: 0.8 to 1 for smooth modes, half next to a
/// singular line.
constexpr double kEnrichedShareSmooth = .78, kEnrichedShareSingular = .5;
/// Successive CG steps add decreasing amounts. The amounts of the steps not taken are extrapolated
/// as a geometric series with at most this ratio.
constexpr double kMaxRatio = .75;

Lanes inner(std::span<const Lanes> a, std::span<const Lanes> b) noexcept {
  Lanes sum{};
  for (std::size_t i = 0; i < a.size(); ++i)
    for (std::size_t c = 0; c < kBlockColumns; ++c)
      sum[c] += a[i][c] * b[i][c];
  return sum;
}

/// Copies columns to lanes; lanes beyond `width` are zero.
void spread(std::span<const double> columns, std::size_t n, std::size_t width,
            std::span<Lanes> out) {
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t c = 0; c < kBlockColumns; ++c)
      out[i][c] = c < width ? columns[c * n + i] : 0;
}

/// Solves S e = r, S = K_WW - K_WV K_VV^-1 K_VW, for up to kBlockColumns modes at once by
/// preconditioned conjugate gradients.
class ErrorSolver {
public:
  ErrorSolver(const EnrichedSystem& system, ShiftedFactor& factor, std::size_t dofs)
      : right(system.unknowns()), e(system.unknowns()), system_(system), factor_(factor), n_(dofs),
        down_(dofs), r_(right), z_(right), p_(right), q_(right), flat_(dofs * kBlockColumns) {}

  std::vector<Lanes> right, e; ///< r on entry, and the solution
  Lanes eta{};                 ///< r'e after all steps so far
  Lanes added{};               ///< added by the last step
  Lanes ratio{};               ///< last step's contribution over the previous one's

  /// Iterates until a step adds less than `settle` of r'e in every column. Returns the number of
  /// steps.
  std::size_t solve(std::size_t width, double settle) {
    r_ = right;
    std::fill(e.begin(), e.end(), Lanes{});
    eta = added = ratio = Lanes{};
    system_.precondition(r_, z_);
    p_ = z_;
    rz_ = inner(r_, z_);
    for (std::size_t step = 0; step < kMaxSteps; ++step) {
      multiply(width);
      if (advance(width, settle))
        return step + 1;
      next_direction(width);
    }
    return kMaxSteps;
  }

private:
  /// q = S p
  void multiply(std::size_t width) {
    system_.multiply(p_, q_, down_);
    for (std::size_t i = 0; i < n_; ++i)
      for (std::size_t c = 0; c < width; ++c)
        flat_[c * n_ + i] = down_[i][c];
    factor_.solve(std::span(flat_).first(n_ * width), flat_, width);
    spread(flat_, n_, width, down_);
    system_.subtract_coupling(down_, q_);
  }
  /// A step along p. Returns whether every column has settled.
  bool advance(std::size_t width, double settle) {
    const Lanes pq = inner(p_, q_);
    Lanes alpha{};
    bool done = true;
    for (std::size_t c = 0; c < width; ++c) {
      alpha[c] = pq[c] > 0 ? rz_[c] / pq[c] : 0;
      ratio[c] = added[c] > 0 ? std::min(alpha[c] * rz_[c] / added[c], kMaxRatio) : 0;
      added[c] = alpha[c] * rz_[c];
      eta[c] += added[c];
      done = done && alpha[c] * rz_[c] <= settle * eta[c];
    }
    for (std::size_t i = 0; i < e.size(); ++i)
      for (std::size_t c = 0; c < kBlockColumns; ++c) {
        e[i][c] += alpha[c] * p_[i][c];
        r_[i][c] -= alpha[c] * q_[i][c];
      }
    return done;
  }
  void next_direction(std::size_t width) {
    system_.precondition(r_, z_);
    const Lanes next = inner(r_, z_);
    Lanes beta{};
    for (std::size_t c = 0; c < width; ++c)
      beta[c] = rz_[c] > 0 ? next[c] / rz_[c] : 0;
    rz_ = next;
    for (std::size_t i = 0; i < p_.size(); ++i)
      for (std::size_t c = 0; c < kBlockColumns; ++c)
        p_[i][c] = z_[i][c] + beta[c] * p_[i][c];
  }

  const EnrichedSystem& system_;
  ShiftedFactor& factor_;
  std::size_t n_;
  std::vector<Lanes> down_, r_, z_, p_, q_;
  std::vector<double> flat_; ///< down_, stored in columns
  Lanes rz_{};
};

/// Number of elements that share each enriching function.
std::vector<int> elements_of_functions(const Enrichment& enrichment) {
  std::vector<int> count(enrichment.count, 0);
  for (const int f : enrichment.number)
    ++count[static_cast<std::size_t>(f)];
  return count;
}

/// Adds each element's contribution to modes `begin` to `begin + width`: r'e of its functions,
/// extrapolated to further steps.
class ErrorShares {
public:
  ErrorShares(const Mesh& mesh, const Enrichment& enrichment,
              std::span<const std::uint8_t> constrained)
      : mesh_(mesh), enrichment_(enrichment), singular_(singular_elements(mesh, constrained)),
        elements_of_(elements_of_functions(enrichment)) {}

  void add(const ErrorSolver& solved, const Lanes& lambda, std::size_t begin, std::size_t width,
           ErrorEstimate& estimate) const {
    Lanes scale{};
    for (std::size_t c = 0; c < width; ++c)
      if (solved.eta[c] > 0)
        scale[c] =
            (1 + solved.added[c] * solved.ratio[c] / ((1 - solved.ratio[c]) * solved.eta[c])) /
            (2 * lambda[c]);
    for (std::size_t element = 0; element < mesh_.elements.size(); ++element) {
      const auto functions = enriching_functions(mesh_.elements[element].shape);
      for (std::size_t a = 0; a < functions.size(); ++a) {
        const auto f = static_cast<std::size_t>(enrichment_.number[enrichment_.first[element] + a]);
        for (std::size_t c = 0; c < width; ++c) {
          double part = 0;
          for (std::size_t k = 0; k < 3; ++k)
            part += solved.right[3 * f + k][c] * solved.e[3 * f + k][c];
          part *= scale[c] / (elements_of_[f] *
                              (singular_[element] ? kEnrichedShareSingular : kEnrichedShareSmooth));
          estimate.relative[begin + c] += part;
          float* to = &estimate.share[((begin + c) * mesh_.elements.size() + element) * 3];
          for (std::size_t axis = 0; axis < 3; ++axis)
            to[axis] += static_cast<float>(part * functions[a].share[axis]);
        }
      }
    }
  }

private:
  const Mesh& mesh_;
  const Enrichment& enrichment_;
  std::vector<std::uint8_t> singular_;
  std::vector<int> elements_of_;
};

} // namespace

ErrorEstimate estimate_errors(const Mesh& mesh, std::span<const Material> materials,
                              const Matrices& matrices, ShiftedFactor& factor, const Modes& modes,
                              const ErrorSettings& settings) {
  const std::size_t n = matrices.dofs(), count = modes.frequency_hz.size();
  const EnrichedSystem system(mesh, materials, matrices);
  const ErrorShares shares(mesh, system.functions(), matrices.constrained);
  ErrorSolver solver(system, factor, n);
  ErrorEstimate estimate;
  estimate.relative.assign(count, 0.0);
  estimate.share.assign(count * mesh.elements.size() * 3, 0.0F);
  std::vector<Lanes> u(n);
  for (std::size_t begin = 0; begin < count; begin += kBlockColumns) {
    const std::size_t width = std::min(kBlockColumns, count - begin);
    Lanes lambda{};
    for (std::size_t c = 0; c < width; ++c)
      lambda[c] = std::pow(2 * std::numbers::pi * modes.frequency_hz[begin + c], 2);
    spread(std::span(modes.shapes).subspan(begin * n, width * n), n, width, u);
    system.residual(materials, u, lambda, solver.right);
    estimate.iterations = std::max(estimate.iterations, solver.solve(width, settings.settle));
    shares.add(solver, lambda, begin, width, estimate);
    if (settings.progress)
      settings.progress(static_cast<double>(begin + width) / static_cast<double>(count));
  }
  return estimate;
}

ErrorCells interval_errors(const Mesh& mesh, std::span<const std::uint8_t> constrained,
                           const ErrorEstimate& estimate, std::size_t intervals) {
  // An interval's order is the mean over its elements, weighted with their contributions to each
  // mode's error.
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
