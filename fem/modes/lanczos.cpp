#include "fem/modes/lanczos.hpp"

#include "fem/modes/dense.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// xorshift64*, which gives the same start vectors everywhere.
double random_unit(std::uint64_t& state) {
  state ^= state >> 12;
  state ^= state << 25;
  state ^= state >> 27;
  return static_cast<double>((state * 0x2545F4914F6CDD1DULL) >> 11) * 0x1p-53 - .5;
}

class Lanczos {
public:
  Lanczos(const Matrices& matrices, ShiftedFactor& factor, std::span<const double> deflated,
          std::size_t max_columns)
      : matrices_(matrices), factor_(factor), deflated_(deflated), n_(matrices.dofs()),
        max_columns_(max_columns) {
    basis_.resize(n_ * max_columns);
    projected_.assign(max_columns * max_columns, 0.0);
  }

  std::size_t width = 0; ///< columns of the basis
  std::size_t solves = 0;
  std::vector<double> next; ///< the block to append, M-orthonormal
  std::size_t next_width = 0;
  std::vector<double> residual; ///< coupling of `next` to the last block: next_width x last_width
  std::size_t last_width = 0;

  void start() {
    std::uint64_t state = 0x9E3779B97F4A7C15ULL;
    next.assign(n_ * kLanczosBlock, 0.0);
    for (double& x : next)
      x = random_unit(state);
    for (std::size_t c = 0; c < kLanczosBlock; ++c)
      for (std::size_t i = 0; i < n_; ++i)
        if (matrices_.constrained[i])
          next[c * n_ + i] = 0;
    weighted_.resize(n_ * kLanczosBlock);
    matrices_.multiply_mass(next, weighted_, kLanczosBlock);
    apply(next, kLanczosBlock); // one solve smooths the random vectors
    next_width = orthonormalise(next, kLanczosBlock, nullptr);
  }

  /// Appends the next block and computes the block after it.
  void step() {
    std::copy(next.begin(), next.begin() + static_cast<std::ptrdiff_t>(n_ * next_width),
              basis_.begin() + static_cast<std::ptrdiff_t>(n_ * width));
    const std::size_t first = width;
    width += next_width;
    last_width = next_width;
    std::vector<double> image(next.begin(),
                              next.begin() + static_cast<std::ptrdiff_t>(n_ * last_width));
    apply(image, last_width);
    std::vector<double> coefficients(width * last_width, 0.0);
    next_width = orthonormalise(image, last_width, &coefficients);
    next = std::move(image);
    for (std::size_t c = 0; c < last_width; ++c)
      for (std::size_t r = 0; r < width; ++r)
        projected_[(first + c) * max_columns_ + r] = projected_[r * max_columns_ + first + c] =
            coefficients[c * width + r];
  }

  [[nodiscard]] Eigenpairs ritz() const {
    std::vector<double> small(width * width);
    for (std::size_t c = 0; c < width; ++c)
      for (std::size_t r = 0; r < width; ++r)
        small[c * width + r] =
            .5 * (projected_[c * max_columns_ + r] + projected_[r * max_columns_ + c]);
    return symmetric_eigenpairs(small, width);
  }

  /// ||residual of Ritz vector k|| in the M norm.
  [[nodiscard]] double residual_norm(const Eigenpairs& pairs, std::size_t k) const {
    const double* tail = &pairs.vectors[k * width + width - last_width];
    double sum = 0;
    for (std::size_t r = 0; r < next_width; ++r) {
      double entry = 0;
      for (std::size_t c = 0; c < last_width; ++c)
        entry += residual[c * next_width + r] * tail[c];
      sum += entry * entry;
    }
    return std::sqrt(sum);
  }

  /// Ritz vectors of the `count` largest values, largest first.
  [[nodiscard]] std::vector<double> vectors(const Eigenpairs& pairs, std::size_t count) const {
    std::vector<double> rotation(width * count), out(n_ * count, 0.0);
    for (std::size_t k = 0; k < count; ++k)
      std::copy_n(&pairs.vectors[(width - 1 - k) * width], width, &rotation[k * width]);
    add_product(1, {std::span(basis_).first(n_ * width), width}, {rotation, count}, out, n_);
    return out;
  }

  /// Keeps the best `count` Ritz vectors and drops the rest.
  void restart(const Eigenpairs& pairs, std::size_t count) {
    const std::vector<double> kept = vectors(pairs, count);
    std::copy(kept.begin(), kept.end(), basis_.begin());
    std::fill(projected_.begin(), projected_.end(), 0.0);
    for (std::size_t k = 0; k < count; ++k)
      projected_[k * max_columns_ + k] = pairs.values[width - 1 - k];
    width = count;
  }

private:
  /// block = (K + s M)^-1 weighted_
  void apply(std::vector<double>& block, std::size_t columns) {
    factor_.solve(std::span(weighted_).first(n_ * columns), block, columns);
    solves += columns;
  }

  /// Makes `block` M-orthonormal, and M-orthogonal to the basis and the deflated vectors; returns
  /// how many independent columns it has. Two sweeps of classical Gram-Schmidt are enough (Giraud
  /// et al. 2005). Adds the coefficients on the basis to `coefficients` and sets `residual`.
  std::size_t orthonormalise(std::vector<double>& block, std::size_t columns,
                             std::vector<double>* coefficients) {
    const auto basis = std::span<const double>(basis_).first(n_ * width);
    const std::size_t fixed = deflated_.size() / n_;
    std::vector<double>& weighted = weighted_;
    weighted.resize(n_ * columns);
    matrices_.multiply_mass(block, weighted, columns);
    std::vector<double> coupling(columns * columns, 0.0);
    for (std::size_t c = 0; c < columns; ++c)
      coupling[c * columns + c] = 1;
    std::size_t rank = columns;
    double first_norm = 0;
    for (int sweep = 0; sweep < 2; ++sweep) {
      if (sweep == 0)
        for (std::size_t c = 0; c < rank; ++c) {
          double norm = 0;
          for (std::size_t i = 0; i < n_; ++i)
            norm += block[c * n_ + i] * weighted[c * n_ + i];
          first_norm = std::max(first_norm, norm);
        }
      const std::vector<double> on_fixed = transposed_product(deflated_, fixed, weighted, rank, n_);
      add_product(-1, {deflated_, fixed}, {on_fixed, rank}, block, n_);
      const std::vector<double> on_basis = transposed_product(basis, width, weighted, rank, n_);
      add_product(-1, {basis, width}, {on_basis, rank}, block, n_);
      if (coefficients) // adds on_basis times the coupling so far
        add_product(1, {on_basis, rank}, {coupling, columns}, *coefficients, width);
      matrices_.multiply_mass(std::span(block).first(n_ * rank), weighted, rank);
      const std::vector<double> gram =
          transposed_product(std::span(block).first(n_ * rank), rank, weighted, rank, n_);
      const Eigenpairs pairs = symmetric_eigenpairs(gram, rank);
      std::size_t dependent = 0;
      const double floor = sweep == 0 ? 1e-24 * first_norm : 1e-8;
      while (dependent < rank && pairs.values[dependent] <= floor)
        ++dependent;
      const std::size_t left = rank - dependent;
      std::vector<double> rotation(rank * left), back(left * rank), rotated(n_ * left, 0.0);
      for (std::size_t k = 0; k < left; ++k) {
        const double root = std::sqrt(pairs.values[dependent + k]);
        for (std::size_t r = 0; r < rank; ++r) {
          const double v = pairs.vectors[(dependent + k) * rank + r];
          rotation[k * rank + r] = v / root;
          back[r * left + k] = v * root;
        }
      }
      add_product(1, {std::span(block).first(n_ * rank), rank}, {rotation, left}, rotated, n_);
      block = std::move(rotated);
      rotated.assign(n_ * left, 0.0);
      add_product(1, {weighted, rank}, {rotation, left}, rotated, n_);
      weighted = std::move(rotated);
      std::vector<double> product(left * columns, 0.0);
      add_product(1, {back, rank}, {coupling, columns}, product, left);
      coupling = std::move(product);
      rank = left;
      if (rank == 0)
        break;
    }
    residual = std::move(coupling);
    return rank;
  }

  const Matrices& matrices_;
  ShiftedFactor& factor_;
  std::span<const double> deflated_;
  std::size_t n_, max_columns_;
  std::vector<double> basis_, projected_, weighted_;
};

} // namespace

Spectrum lowest_modes(const Matrices& matrices, ShiftedFactor& factor, double shift,
                      std::span<const double> deflated, const LanczosSettings& settings) {
  const std::size_t n = matrices.dofs();
  const auto constrained = static_cast<std::size_t>(
      std::count(matrices.constrained.begin(), matrices.constrained.end(), 1));
  const std::size_t possible = n - constrained - deflated.size() / n;
  std::size_t count = std::min(settings.count, possible);
  const std::size_t max_columns =
      std::min(4 * count + 12 * kLanczosBlock, possible + kLanczosBlock);
  Lanczos lanczos(matrices, factor, deflated, max_columns + kLanczosBlock);
  lanczos.start();
  Eigenpairs pairs;
  for (int blocks = 0; count > 0; ++blocks) {
    if (lanczos.next_width > 0)
      lanczos.step();
    // Most pairs converge in the last few blocks, so progress is estimated from the number of
    // solves. The iteration ends when the pairs have converged.
    if (settings.progress)
      settings.progress(std::min(.95, static_cast<double>(lanczos.solves) /
                                          static_cast<double>(2 * count + 100)));
    const bool exhausted = lanczos.next_width == 0 || lanczos.width >= possible;
    const bool full = lanczos.width + lanczos.next_width > max_columns;
    if (!(exhausted || full || (lanczos.width >= count + kLanczosBlock && blocks % 3 == 0)))
      continue;
    pairs = lanczos.ritz();
    std::size_t found = 0;
    while (found < std::min(count, lanczos.width)) {
      const std::size_t k = lanczos.width - 1 - found;
      if (!exhausted && lanczos.residual_norm(pairs, k) > settings.tolerance * pairs.values[k])
        break;
      ++found;
    }
    if (settings.progress)
      settings.progress(static_cast<double>(found) / static_cast<double>(count));
    if (found == count || exhausted)
      break;
    if (full)
      lanczos.restart(pairs, std::min(count + 2 * kLanczosBlock, lanczos.width));
    if (blocks > 2000)
      throw InputError("the modes do not converge after " + std::to_string(lanczos.solves) +
                       " solves: check the mesh for distorted elements");
  }
  Spectrum spectrum;
  count = std::min(count, lanczos.width);
  spectrum.solves = lanczos.solves;
  spectrum.vectors = lanczos.vectors(pairs, count);
  for (std::size_t k = 0; k < count; ++k)
    spectrum.lambda.push_back(1 / pairs.values[lanczos.width - 1 - k] - shift);
  return spectrum;
}

} // namespace tactus::fem
