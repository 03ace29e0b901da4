#include "fem/statics/recovery.hpp"

#include "fem/element/tabulated.hpp"
#include "fem/small_dense.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// A stress's derivative by x, y and z.
using Gradient = std::array<Stress, 3>;

Stress difference(const Stress& a, const Stress& b) {
  Stress out{};
  for (std::size_t v = 0; v < 6; ++v)
    out[v] = a[v] - b[v];
  return out;
}

/// M^-1 of a sum of d d', without the directions that hardly any d has.
std::array<Vec3, 3> inverse_of_squares(const std::array<Vec3, 3>& m) {
  constexpr double kCarried = 1e-2; // relative to the largest square
  const Eigenpairs3 pairs = symmetric_eigenpairs(m);
  std::array<Vec3, 3> inverse{};
  for (std::size_t k = 0; k < 3; ++k)
    if (pairs.values[k] > kCarried * pairs.values[2])
      for (int i = 0; i < 3; ++i)
        inverse[static_cast<std::size_t>(i)] +=
            (pairs.vectors[k][i] / pairs.values[k]) * pairs.vectors[k];
  return inverse;
}

/// The slopes of values over positions d by least squares: `values[v]` = `slope`[axis][v] d.
class Slopes {
public:
  void add(const Vec3& d, double weight, const Stress& value) {
    for (int i = 0; i < 3; ++i) {
      squares_[static_cast<std::size_t>(i)] += (weight * d[i]) * d;
      for (std::size_t v = 0; v < 6; ++v)
        right_[static_cast<std::size_t>(i)][v] += weight * d[i] * value[v];
    }
  }
  [[nodiscard]] Gradient solve() const {
    const auto inverse = inverse_of_squares(squares_);
    Gradient slope{};
    for (std::size_t i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (std::size_t v = 0; v < 6; ++v)
          slope[i][v] += inverse[i][j] * right_[static_cast<std::size_t>(j)][v];
    return slope;
  }

private:
  std::array<Vec3, 3> squares_{};
  Gradient right_{};
};

/// An element's centre, the stress there and its gradient, from the element's superconvergent
/// points.
struct LinearStress {
  Vec3 middle;
  Stress mean{};
  Gradient gradient{};
};

LinearStress linear_of(std::span<const StressSample> samples) {
  LinearStress out;
  const double share = 1 / static_cast<double>(samples.size());
  for (const StressSample& s : samples) {
    out.middle += share * s.at;
    for (std::size_t v = 0; v < 6; ++v)
      out.mean[v] += share * s.stress[v];
  }
  Slopes slopes;
  for (const StressSample& s : samples)
    slopes.add(s.at - out.middle, 1, difference(s.stress, out.mean));
  if (samples.size() > 1)
    out.gradient = slopes.solve();
  return out;
}

/// Numbers in rows of uneven length.
struct Rows {
  std::vector<std::size_t> first;
  std::vector<int> all;
  [[nodiscard]] std::span<const int> operator[](std::size_t i) const {
    return std::span(all).subspan(first[i], first[i + 1] - first[i]);
  }
};

Rows elements_of_nodes(const Mesh& mesh) {
  Rows rows{std::vector<std::size_t>(mesh.nodes.size() + 1, 0), {}};
  for (const Element& e : mesh.elements)
    for (const int n : mesh.nodes_of(e))
      ++rows.first[static_cast<std::size_t>(n) + 1];
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    rows.first[n + 1] += rows.first[n];
  rows.all.resize(rows.first.back());
  std::vector<std::size_t> next(rows.first.begin(), rows.first.end() - 1);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int n : mesh.nodes_of(mesh.elements[e]))
      rows.all[next[static_cast<std::size_t>(n)]++] = static_cast<int>(e);
  return rows;
}

/// x' H x / 2 for an element's curvature H, which is the gradient of each component of its
/// gradient.
Stress curved(const std::array<Gradient, 3>& h, const Vec3& x) {
  Stress out{};
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      for (std::size_t v = 0; v < 6; ++v)
        out[v] += .5 * x[i] * x[j] * h[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)][v];
  return out;
}

} // namespace

RecoveredStress recovered_stress(const Mesh& mesh, std::span<const Material> materials,
                                 std::span<const double> displacement) {
  const auto samples = best_stress(mesh, materials, displacement);
  std::vector<LinearStress> linear;
  for (const auto& own : samples)
    linear.push_back(linear_of(own));
  const Rows around = elements_of_nodes(mesh);
  RecoveredStress out{std::vector<Stress>(mesh.nodes.size(), Stress{}),
                      std::vector<double>(mesh.nodes.size(), 0.0)};
  std::vector<Stress> missed(mesh.nodes.size(), Stress{});
  std::vector<double> weight(mesh.nodes.size(), 0.0);
  std::vector<std::vector<Stress>> at_node(mesh.elements.size());
  std::vector<int> seen(mesh.elements.size(), -1);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const Element& element = mesh.elements[e];
    const auto nodes = mesh.nodes_of(element);
    std::array<Slopes, 3> curvature{};
    seen[e] = static_cast<int>(e);
    for (const int n : nodes)
      for (const int other : around[static_cast<std::size_t>(n)]) {
        const auto j = static_cast<std::size_t>(other);
        if (seen[j] == static_cast<int>(e) || mesh.elements[j].region != element.region)
          continue;
        seen[j] = static_cast<int>(e);
        const Vec3 d = linear[j].middle - linear[e].middle;
        for (std::size_t i = 0; i < 3; ++i)
          curvature[i].add(d, 1 / dot(d, d),
                           difference(linear[j].gradient[i], linear[e].gradient[i]));
      }
    const std::array<Gradient, 3> h{curvature[0].solve(), curvature[1].solve(),
                                    curvature[2].solve()};
    std::vector<Stress> curved_points;
    for (const StressSample& s : samples[e])
      curved_points.push_back(curved(h, s.at - linear[e].middle));
    const double volume = volume_of(mesh, element);
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto n = static_cast<std::size_t>(nodes[a]);
      Stress own{}, lost = curved(h, mesh.nodes[n] - linear[e].middle);
      const auto shares = shares_of_best_points(element.shape, a);
      for (std::size_t p = 0; p < shares.size(); ++p)
        for (std::size_t v = 0; v < 6; ++v) {
          own[v] += shares[p] * samples[e][p].stress[v];
          lost[v] -= shares[p] * curved_points[p][v];
        }
      weight[n] += volume;
      for (std::size_t v = 0; v < 6; ++v) {
        own[v] += lost[v];
        out.at_nodes[n][v] += volume * own[v];
        missed[n][v] += volume * lost[v];
      }
      at_node[e].push_back(own);
    }
  }
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    for (std::size_t v = 0; v < 6; ++v) {
      out.at_nodes[n][v] /= weight[n] > 0 ? weight[n] : 1;
      missed[n][v] /= weight[n] > 0 ? weight[n] : 1;
    }
    out.error[n] = von_mises(missed[n]);
  }
  // The estimate at one node may vanish by chance, so each node takes the largest estimate in its
  // elements.
  const std::vector<double> curved_by = out.error;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const auto nodes = mesh.nodes_of(mesh.elements[e]);
    double largest = 0;
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto n = static_cast<std::size_t>(nodes[a]);
      largest =
          std::max({largest, curved_by[n], von_mises(difference(at_node[e][a], out.at_nodes[n]))});
    }
    for (const int n : nodes)
      out.error[static_cast<std::size_t>(n)] =
          std::max(out.error[static_cast<std::size_t>(n)], largest);
  }
  return out;
}

std::vector<Stress> at_middles(const Mesh& mesh, std::span<const Stress> at_nodes) {
  std::vector<Stress> out;
  for (const Element& e : mesh.elements) {
    Stress& sum = out.emplace_back();
    const auto nodes = mesh.nodes_of(e);
    const ShapeValues& values = at_centroid(e.shape);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t v = 0; v < 6; ++v)
        sum[v] += values.value[a] * at_nodes[static_cast<std::size_t>(nodes[a])][v];
  }
  return out;
}

} // namespace tactus::fem
