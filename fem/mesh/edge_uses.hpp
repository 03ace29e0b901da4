#pragma once
#include "fem/io/triangles.hpp"

#include <algorithm>

namespace tactus::fem {

/// One side of a triangle: the edge from a to b, a < b, the triangle, and whether the triangle runs
/// from a to b.
struct EdgeUse {
  int a, b;
  std::size_t triangle, side;
  bool forward;
};

/// The sides of all triangles, in ascending order, so that all uses of an edge are adjacent.
[[nodiscard]] inline std::vector<EdgeUse> edge_uses(const Triangles& t) {
  std::vector<EdgeUse> uses;
  uses.reserve(3 * t.triangles.size());
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const int a = t.triangles[i][k], b = t.triangles[i][(k + 1) % 3];
      uses.push_back({std::min(a, b), std::max(a, b), i, k, a < b});
    }
  std::stable_sort(uses.begin(), uses.end(), [](const EdgeUse& x, const EdgeUse& y) {
    return x.a != y.a ? x.a < y.a : x.b < y.b;
  });
  return uses;
}

/// Calls use(first, last) for the uses of each edge.
template <class Uses, class Use> void for_each_edge(Uses& uses, Use&& use) {
  for (auto first = uses.begin(); first != uses.end();) {
    auto last = first;
    while (last != uses.end() && last->a == first->a && last->b == first->b)
      ++last;
    use(first, last);
    first = last;
  }
}

} // namespace tactus::fem
