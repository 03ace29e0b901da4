#include "fem/modes/rigid.hpp"

#include "fem/modes/dense.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// Energy limit per node, relative to the stiffness of the stiffest node; rounding leaves about
/// 1e-16 in a rigid motion.
constexpr double kNoEnergy = 3e-15;

std::vector<double> trial_motions(const Mesh& mesh, const Parts& parts) {
  const std::size_t n = mesh.dofs();
  std::vector<double> trial(n * 6 * static_cast<std::size_t>(parts.count), 0.0);
  std::vector<Vec3> centre(static_cast<std::size_t>(parts.count));
  std::vector<double> nodes(centre.size(), 0.0), radius(centre.size(), 0.0);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const auto part = static_cast<std::size_t>(parts.of_node[i]);
    centre[part] += mesh.nodes[i];
    nodes[part] += 1;
  }
  for (std::size_t p = 0; p < centre.size(); ++p)
    centre[p] = (1 / nodes[p]) * centre[p];
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const auto p = static_cast<std::size_t>(parts.of_node[i]);
    radius[p] = std::max(radius[p], length(mesh.nodes[i] - centre[p]));
  }
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const auto p = static_cast<std::size_t>(parts.of_node[i]);
    const Vec3 arm = (1 / radius[p]) * (mesh.nodes[i] - centre[p]);
    for (int k = 0; k < 3; ++k) {
      Vec3 axis;
      axis[k] = 1;
      const Vec3 rotation = cross(axis, arm);
      for (int d = 0; d < 3; ++d) {
        const std::size_t row = 3 * i + static_cast<std::size_t>(d);
        trial[(6 * p + static_cast<std::size_t>(k)) * n + row] = axis[d];
        trial[(6 * p + 3 + static_cast<std::size_t>(k)) * n + row] = rotation[d];
      }
    }
  }
  return trial;
}

} // namespace

std::vector<double> rigid_motions(const Mesh& mesh, const Matrices& m) {
  const std::size_t n = m.dofs();
  const Parts parts = connected_parts(mesh);
  const auto count = 6 * static_cast<std::size_t>(parts.count);
  std::vector<double> trial = trial_motions(mesh, parts);

  double scale = 0; // largest diagonal of K: the energy if only one node moves
  for (std::size_t node = 0; node < m.graph.node_count(); ++node)
    for (const std::size_t i : {0u, 4u, 8u})
      scale = std::max(scale, m.stiffness[9 * m.graph.find(static_cast<std::int64_t>(node),
                                                           static_cast<std::int64_t>(node)) +
                                          i]);
  // The cost of each motion: its strain energy, plus the squared displacement of constrained nodes.
  // Uses K with its constrained rows, since a trial motion may move them.
  std::vector<double> image(n * count);
  Matrices free = m;
  std::fill(free.constrained.begin(), free.constrained.end(), std::uint8_t{0});
  free.multiply_stiffness(trial, image, count);
  std::vector<double> cost = transposed_product(trial, count, image, count, n);
  for (std::size_t a = 0; a < count; ++a)
    for (std::size_t b = 0; b < count; ++b) {
      double violation = 0;
      for (std::size_t i = 0; i < n; ++i)
        if (m.constrained[i])
          violation += trial[a * n + i] * trial[b * n + i];
      cost[b * count + a] = cost[b * count + a] / scale + violation;
    }
  const Eigenpairs motions = symmetric_eigenpairs(cost, count);
  std::size_t rigid = 0;
  while (rigid < count &&
         motions.values[rigid] < kNoEnergy * static_cast<double>(m.graph.node_count()))
    ++rigid;
  if (rigid == 0)
    return {};
  std::vector<double> found(n * rigid, 0.0);
  add_product(1, {trial, count}, {std::span(motions.vectors).first(count * rigid), rigid}, found,
              n);
  for (std::size_t i = 0; i < n; ++i)
    if (m.constrained[i])
      for (std::size_t c = 0; c < rigid; ++c)
        found[c * n + i] = 0;

  // Makes the motions orthonormal with respect to the mass.
  std::vector<double> weighted(n * rigid);
  m.multiply_mass(found, weighted, rigid);
  const Eigenpairs gram =
      symmetric_eigenpairs(transposed_product(found, rigid, weighted, rigid, n), rigid);
  std::vector<double> rotation = gram.vectors, result(n * rigid, 0.0);
  for (std::size_t c = 0; c < rigid; ++c)
    for (std::size_t r = 0; r < rigid; ++r)
      rotation[c * rigid + r] /= std::sqrt(gram.values[c]);
  add_product(1, {found, rigid}, {rotation, rigid}, result, n);
  return result;
}

} // namespace tactus::fem
