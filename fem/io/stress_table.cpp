#include "fem/io/stress_table.hpp"

#include "fem/io/mesh_bytes.hpp"
#include "fem/io/meta.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/simplify.hpp"
#include "files/json.hpp"

#include <map>

namespace tactus::fem {
namespace {

std::string joined(const std::vector<std::string>& words) {
  std::string out;
  for (const std::string& word : words)
    out += (out.empty() ? "" : "; ") + word;
  return out;
}

std::string meta_of(const StressTable& t) {
  const StressMetadata& metadata = t.metadata;
  std::string out =
      meta_head({"stress-table", "part_stress", "{\"stress\": \"Pa\", \"length\": \"m\"}", "name",
                 metadata.created, metadata.body_name},
                t.mesh, t.materials);
  out += "], \"supports\": " + list(metadata.supports) +
         ", \"loads\": " + files::quoted_json(joined(metadata.loads)) +
         ", \"load_list\": " + list(metadata.loads) +
         format(", \"lattice\": [%d, %d, %d]", t.lattice[0], t.lattice[1], t.lattice[2]) +
         format(", \"mass\": %.9g, \"volume\": %.9g, \"max_displacement\": %.9g", metadata.mass,
                metadata.volume, metadata.max_displacement) +
         format(", \"costs\": {\"product_s\": %.3g, \"solve_s\": %.3g, \"factor_s\": %.3g}",
                metadata.product_s, metadata.solve_s, metadata.factor_s) +
         ", \"command\": " + list(metadata.command) + "}";
  return out;
}

std::vector<float> singles(std::span<const double> values) {
  return {values.begin(), values.end()};
}

/// A coarser skin, whose corners are a subset of the skin's vertices.
Surface coarser(const Mesh& mesh, const Surface& skin, double edge) {
  constexpr double kDeviation = 0.15; // relative to the edge
  Triangles triangles;
  std::map<std::array<double, 3>, int> node_at;
  for (const int node : skin.node) {
    const Vec3& p = mesh.nodes[static_cast<std::size_t>(node)];
    triangles.points.push_back(p);
    node_at.emplace(std::array{p.x, p.y, p.z}, node);
  }
  triangles.triangles = skin.triangles;
  triangles.shell.assign(skin.triangles.size(), 0);
  triangles.shells = 1;
  triangles = simplified(
      triangles, [edge](const Vec3&) { return edge; }, kDeviation * edge);
  Surface out;
  for (const Vec3& p : triangles.points)
    out.node.push_back(node_at.at({p.x, p.y, p.z}));
  out.triangles = triangles.triangles;
  return out;
}

/// [V,C]: the displacement of each vertex relative to that of a control point.
std::vector<float> weights_of(const ControlWeights& weights, const Surface& skin) {
  const std::size_t controls = weights.control_points.size();
  std::vector<float> out(skin.node.size() * controls, 0);
  for (std::size_t v = 0; v < skin.node.size(); ++v) {
    const auto node = static_cast<std::size_t>(skin.node[v]);
    for (std::size_t k = weights.start[node]; k < weights.start[node + 1]; ++k)
      out[v * controls + static_cast<std::size_t>(weights.control[k])] =
          static_cast<float>(weights.weight[k]);
  }
  return out;
}

} // namespace

std::vector<std::int32_t> element_of_vertices(const Mesh& mesh, const Surface& skin,
                                              std::span<const double> volumes) {
  constexpr double kEqual =
      1e-9; // among equal elements, odd nodes take the last one, to favour no side
  std::vector<std::int32_t> owner(mesh.nodes.size(), -1);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int node : mesh.nodes_of(mesh.elements[e])) {
      std::int32_t& at = owner[static_cast<std::size_t>(node)];
      const double ratio = at < 0 ? 2 : volumes[e] / volumes[static_cast<std::size_t>(at)];
      if (ratio > 1 + kEqual || (ratio > 1 - kEqual && node % 2 == 1))
        at = static_cast<std::int32_t>(e);
    }
  std::vector<std::int32_t> out;
  out.reserve(skin.node.size());
  for (const int node : skin.node)
    out.push_back(owner[static_cast<std::size_t>(node)]);
  return out;
}

void write_stress_table(const std::string& path, const StressTable& t) {
  const std::size_t elements = t.mesh.elements.size(), parameters = t.parameters.size();
  const Surface whole = surface_of(t.mesh);
  const Surface skin = t.skin_edge > 0 ? coarser(t.mesh, whole, t.skin_edge) : whole;
  const auto& control_points = t.control_weights.control_points;
  std::vector<Vec3> vertices;
  for (const int node : skin.node)
    vertices.push_back(t.mesh.nodes[static_cast<std::size_t>(node)]);
  std::vector<std::int32_t> triangles;
  for (const auto& triangle : skin.triangles)
    triangles.insert(triangles.end(), triangle.begin(), triangle.end());
  std::vector<double> rows;
  for (const ParameterRange& p : t.parameters)
    rows.insert(rows.end(),
                {static_cast<double>(p.control), static_cast<double>(p.axis), p.low, p.high});
  const std::string meta = meta_of(t), mesh = to_bytes(t.mesh);
  const std::vector<std::uint8_t> meta_bytes(meta.begin(), meta.end()),
      mesh_bytes(mesh.begin(), mesh.end());
  NpzWriter npz;
  npz.add("meta", meta_bytes, {meta_bytes.size()});
  npz.add("s0", singles(t.von_mises), {elements});
  npz.add("shear0", singles(t.max_shear), {elements});
  npz.add("S", t.sensitivity.von_mises, {parameters, elements});
  npz.add("S_shear", t.sensitivity.max_shear, {parameters, elements});
  npz.add("weights", singles(t.volumes), {elements});
  npz.add("parameters", rows, {parameters, 4});
  npz.add("control_points", coordinates(control_points), {control_points.size(), 3});
  npz.add("trust", std::span(&t.trust, 1), {});
  npz.add("surface_nodes", coordinates(vertices), {vertices.size(), 3});
  npz.add("surface_triangles", triangles, {skin.triangles.size(), 3});
  npz.add("surface_node_element", element_of_vertices(t.mesh, skin, t.volumes), {vertices.size()});
  npz.add("surface_weights", weights_of(t.control_weights, skin),
          {vertices.size(), control_points.size()});
  npz.add("mesh", mesh_bytes, {mesh_bytes.size()});
  write_npz(path, npz);
}

} // namespace tactus::fem
