#include "fem/modes/residual_compliance.hpp"

#include "fem/modes/rigid.hpp"

#include <algorithm>
#include <limits>
#include <numbers>

namespace tactus::fem {
namespace {

constexpr std::size_t kColumns = 8;

/// Normal times area at each vertex, a third of the triangles around it.
std::vector<Vec3> vertex_areas(const Mesh& mesh, const Surface& skin) {
  std::vector<Vec3> area(skin.node.size());
  const auto at = [&](int v) {
    return mesh.nodes[static_cast<std::size_t>(skin.node[static_cast<std::size_t>(v)])];
  };
  for (const auto& [a, b, c] : skin.triangles)
    for (const int v : {a, b, c})
      area[static_cast<std::size_t>(v)] += (1. / 6) * cross(at(b) - at(a), at(c) - at(a));
  return area;
}

double mean_edge(const Mesh& mesh, const Surface& skin) {
  double sum = 0;
  for (const auto& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      sum +=
          length(mesh.nodes[static_cast<std::size_t>(skin.node[static_cast<std::size_t>(t[k])])] -
                 mesh.nodes[static_cast<std::size_t>(
                     skin.node[static_cast<std::size_t>(t[(k + 1) % 3])])]);
  return sum / (3 * static_cast<double>(skin.triangles.size()));
}

/// Vertices chosen one after another, each as far as possible from the earlier ones.
std::vector<std::size_t> spread_out(const std::vector<Vec3>& points, std::size_t count) {
  std::vector<double> nearest(points.size(), std::numeric_limits<double>::infinity());
  std::vector<std::size_t> chosen;
  for (std::size_t next = 0; chosen.size() < std::min(count, points.size());) {
    chosen.push_back(next);
    for (std::size_t v = 0; v < points.size(); ++v)
      nearest[v] = std::min(nearest[v], length(points[v] - points[chosen.back()]));
    next = static_cast<std::size_t>(std::max_element(nearest.begin(), nearest.end()) -
                                    nearest.begin());
  }
  return chosen;
}

/// Removes from a force the part that accelerates the body as a rigid body, which causes no
/// deformation; `heavy` are the rigid motions times the mass.
void remove_rigid_part(std::span<const double> rigid, std::span<const double> heavy,
                       std::span<double> force) {
  const std::size_t n = force.size();
  for (std::size_t r = 0; r < rigid.size(); r += n) {
    double along = 0;
    for (std::size_t i = 0; i < n; ++i)
      along += rigid[r + i] * force[i];
    for (std::size_t i = 0; i < n; ++i)
      force[i] -= along * heavy[r + i];
  }
}

/// Means over the four nearest chosen vertices, weighted with the inverse square of distance.
std::vector<float> interpolated(const std::vector<Vec3>& points,
                                const std::vector<std::size_t>& chosen,
                                const std::vector<double>& deflections, double radius) {
  std::vector<float> everywhere;
  for (const Vec3& p : points) {
    std::vector<std::pair<double, std::size_t>> near;
    for (std::size_t c = 0; c < chosen.size(); ++c)
      near.emplace_back(length(p - points[chosen[c]]), c);
    const std::size_t count = std::min<std::size_t>(4, near.size());
    std::partial_sort(near.begin(), near.begin() + static_cast<std::ptrdiff_t>(count), near.end());
    double sum = 0, weights = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double weight = 1 / (near[i].first * near[i].first + 1e-6 * radius * radius);
      sum += weight * deflections[near[i].second];
      weights += weight;
    }
    everywhere.push_back(static_cast<float>(sum / weights));
  }
  return everywhere;
}

} // namespace

PushPatch push_patch(const Mesh& mesh, const Surface& skin, std::size_t vertex, double radius) {
  const auto area = vertex_areas(mesh, skin);
  const auto at = [&](std::size_t v) { return mesh.nodes[static_cast<std::size_t>(skin.node[v])]; };
  PushPatch patch;
  for (std::size_t v = 0; v < area.size(); ++v) {
    const double size = length(area[v]);
    // The force does not act on the far side of a thin wall or on faces beyond a sharp edge.
    if (length(at(v) - at(vertex)) > radius || !(size > 0) ||
        dot(area[v], area[vertex]) < .7 * size * length(area[vertex]))
      continue;
    patch.node.push_back(static_cast<std::size_t>(skin.node[v]));
    patch.force.push_back(-1. * area[v]);
    patch.area += size;
  }
  for (Vec3& f : patch.force)
    f = (1 / patch.area) * f;
  return patch;
}

std::vector<float> residual_compliance(const Mesh& mesh, std::span<const Material> materials,
                                       const Matrices& matrices, const Modes& modes,
                                       std::size_t probe_count, const Progress& progress) {
  const Surface skin = surface_of(mesh);
  std::vector<Vec3> points;
  for (const int node : skin.node)
    points.push_back(mesh.nodes[static_cast<std::size_t>(node)]);
  const auto chosen = spread_out(points, probe_count);
  const double radius = 3 * mean_edge(mesh, skin);
  const std::size_t n = matrices.dofs();
  const std::vector<double> rigid = rigid_motions(mesh, matrices);
  std::vector<double> heavy(rigid.size());
  if (!rigid.empty())
    matrices.multiply_mass(rigid, heavy, rigid.size() / n);
  const double root = 2 * std::numbers::pi * .1 * modes.frequency_hz.front(), shift = root * root;
  ShiftedFactor factor(matrices, shift);
  if (progress)
    progress(0);
  factor.factorise();

  const Material& m = materials[0];
  const double soft = 16 * (1 - m.poisson[0] * m.poisson[0]) /
                      (3 * std::numbers::pi * std::numbers::pi * m.young_pa[0]);
  std::vector<double> deflections(chosen.size(), 0.0);
  for (std::size_t first = 0; first < chosen.size(); first += kColumns) {
    const std::size_t columns = std::min(kColumns, chosen.size() - first);
    std::vector<double> push(n * columns, 0.0), moved(n * columns);
    std::vector<PushPatch> patches;
    for (std::size_t c = 0; c < columns; ++c) {
      double* f = &push[c * n];
      patches.push_back(push_patch(mesh, skin, chosen[first + c], radius));
      for (std::size_t i = 0; i < patches[c].node.size(); ++i)
        for (std::size_t k = 0; k < 3; ++k)
          if (!matrices.constrained[3 * patches[c].node[i] + k])
            f[3 * patches[c].node[i] + k] = patches[c].force[i][static_cast<int>(k)];
      remove_rigid_part(rigid, heavy, {f, n});
    }
    factor.solve(push, moved, columns);
    if (progress)
      progress(static_cast<double>(first + columns) / static_cast<double>(chosen.size()));
    for (std::size_t c = 0; c < columns; ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < n; ++i)
        sum += push[c * n + i] * moved[c * n + i];
      for (std::size_t k = 0; k < modes.frequency_hz.size(); ++k) {
        double along = 0;
        for (std::size_t i = 0; i < patches[c].node.size(); ++i) {
          const double* u = &modes.shapes[k * n + 3 * patches[c].node[i]];
          along += dot(patches[c].force[i], {u[0], u[1], u[2]});
        }
        const double omega = 2 * std::numbers::pi * modes.frequency_hz[k];
        sum -= along * along / (omega * omega + shift);
      }
      deflections[first + c] =
          std::max(sum - soft / std::sqrt(patches[c].area / std::numbers::pi), 0.0);
    }
  }

  return interpolated(points, chosen, deflections, radius);
}

} // namespace tactus::fem
