#include "fem/modes/mode_match.hpp"

#include "fem/modes/dense.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace tactus::fem {
namespace {

constexpr double kLinked = .1;    // smallest MAC of linked modes
constexpr double kMatched = .5;   // smallest square of a singular value for a match
constexpr double kNoShare = 1e-9; // smaller shares are rounding errors

/// The matrix c of the declaration, [before][now].
std::vector<double> correlation(const Matrices& m, std::span<const double> before,
                                std::span<const double> now) {
  const std::size_t n = m.dofs(), p = now.size() / n, q = before.size() / n;
  std::vector<double> heavy(before.size());
  m.multiply_mass(before, heavy, q);
  std::vector<double> c = transposed_product(now, p, heavy, q, n);
  for (std::size_t i = 0; i < q; ++i) {
    double mass = 0;
    for (std::size_t d = 0; d < n; ++d)
      mass += before[i * n + d] * heavy[i * n + d];
    for (std::size_t j = 0; j < p; ++j)
      c[i * p + j] /= std::sqrt(mass);
  }
  return c;
}

} // namespace

std::vector<ModeMatch> match_modes(const Matrices& m, std::span<const double> before,
                                   std::span<const double> now) {
  const std::size_t p = now.size() / m.dofs(), q = before.size() / m.dofs();
  const std::vector<double> c = correlation(m, before, now);
  // Sets of linked modes: first the earlier modes, then the new ones.
  std::vector<std::size_t> parent(q + p);
  std::iota(parent.begin(), parent.end(), std::size_t{0});
  const auto root = [&](std::size_t a) {
    while (parent[a] != a)
      a = parent[a] = parent[parent[a]];
    return a;
  };
  for (std::size_t i = 0; i < q; ++i)
    for (std::size_t j = 0; j < p; ++j)
      if (c[i * p + j] * c[i * p + j] >= kLinked)
        parent[root(q + j)] = root(i);
  std::vector<std::vector<std::size_t>> groups_before(q + p), groups_now(q + p);
  for (std::size_t i = 0; i < q; ++i)
    groups_before[root(i)].push_back(i);
  for (std::size_t j = 0; j < p; ++j)
    groups_now[root(q + j)].push_back(j);

  std::vector<ModeMatch> matches;
  for (std::size_t set = 0; set < q + p; ++set) {
    const auto& from = groups_before[set];
    const auto& to = groups_now[set];
    if (from.empty() || to.empty())
      continue;
    const std::size_t width = from.size(), height = to.size();
    std::vector<double> part(width * height); // column-major, one column for each earlier mode
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < height; ++j)
        part[i * height + j] = c[from[i] * p + to[j]];
    const Eigenpairs squares =
        symmetric_eigenpairs(transposed_product(part, width, part, width, height), width);
    std::vector<double> share(width * height, 0);
    for (std::size_t s = 0; s < width; ++s) {
      if (squares.values[s] < kMatched)
        continue;
      const double* v = &squares.vectors[s * width];
      for (std::size_t j = 0; j < height; ++j) {
        double along = 0; // component of the left singular vector
        for (std::size_t i = 0; i < width; ++i)
          along += part[i * height + j] * v[i];
        along /= std::sqrt(squares.values[s]);
        for (std::size_t i = 0; i < width; ++i)
          share[i * height + j] += along * v[i];
      }
    }
    for (std::size_t i = 0; i < width; ++i)
      for (std::size_t j = 0; j < height; ++j)
        if (std::abs(share[i * height + j]) > kNoShare)
          matches.push_back({from[i], to[j], std::clamp(share[i * height + j], -1.0, 1.0)});
  }
  return matches;
}

} // namespace tactus::fem
