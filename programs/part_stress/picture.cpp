#include "programs/part_stress/picture.hpp"

#include "fem/error/singular.hpp"
#include "fem/io/meta.hpp"
#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/statics/recovery.hpp"
#include "files/json.hpp"

#include <algorithm>
#include <array>
#include <filesystem>
#include <numbers>
#include <numeric>

namespace tactus::fem {
namespace {

std::vector<Vec3> positions(const Mesh& mesh, std::span<const int> nodes) {
  std::vector<Vec3> out;
  out.reserve(nodes.size());
  for (const int n : nodes)
    out.push_back(mesh.nodes[static_cast<std::size_t>(n)]);
  return out;
}

Vec3 middle(std::span<const Vec3> points) {
  Vec3 sum;
  for (const Vec3& p : points)
    sum += p;
  return (1 / static_cast<double>(std::max<std::size_t>(points.size(), 1))) * sum;
}

/// A load's position, its total force and its label.
struct Arrow {
  Vec3 at, force;
  std::string words;
};

std::vector<Arrow> arrows_of(const Mesh& mesh, const StaticModel& model) {
  std::vector<Arrow> arrows;
  for (const Load& load : model.loads) {
    const Vec3 force = sum_of_forces(load_vector(mesh, model.materials, std::span(&load, 1)));
    Vec3 at = middle(mesh.nodes);
    const auto on_faces = [&](const auto& l) {
      at = middle(positions(mesh, nodes_of_faces(mesh, l.faces)));
    };
    std::string words = format(length(force) < 1e3 ? "%.4g N" : "%.0f N", length(force));
    if (const auto* traction = std::get_if<Traction>(&load))
      on_faces(*traction);
    else if (const auto* total = std::get_if<TotalForce>(&load))
      on_faces(*total);
    else if (const auto* bolt = std::get_if<BoltLoad>(&load))
      on_faces(*bolt);
    else if (const auto* point = std::get_if<PointForce>(&load))
      at = mesh.nodes[static_cast<std::size_t>(point->node)];
    else if (const auto* pressure = std::get_if<Pressure>(&load)) {
      on_faces(*pressure);
      words = format("%.4g MPa", 1e-6 * pressure->pressure_pa);
    } else
      words = "weight " + words;
    arrows.push_back({at, force, words});
  }
  return arrows;
}

/// Positions of the skin's nodes that are fixed or on springs, as x, y, z in turn, m.
std::vector<double> constrained_points(const Mesh& start, const StaticModel& model,
                                       const Surface& skin) {
  std::vector<double> constrained;
  for (const FixedPatch& patch : model.fixed)
    for (const int n : patch.nodes)
      if (std::binary_search(skin.node.begin(), skin.node.end(), n)) {
        const Vec3& p = start.nodes[static_cast<std::size_t>(n)];
        constrained.insert(constrained.end(), {p.x, p.y, p.z});
      }
  for (const SpringPatch& patch : model.springs)
    for (const Vec3& p : positions(start, nodes_of_faces(start, patch.faces)))
      constrained.insert(constrained.end(), {p.x, p.y, p.z});
  return constrained;
}

/// Largest stress, its position and its error, mean stress of the elements and its error, largest
/// displacement, volume, and whether the largest stress is at a singular corner.
std::array<double, 10> numbers_of(const PictureState& s) {
  const Vec3& at = s.nodes[s.peak];
  return {s.von_mises[s.peak],
          at.x,
          at.y,
          at.z,
          s.error[s.peak],
          mean(s.at_elements),
          std::abs(mean(s.missing_at_elements)),
          s.max_displacement,
          s.volume,
          double(s.peak_away.has_value())};
}

/// Marks nodes near a singular corner. A corner is on a concave edge, on the border of a support,
/// or at a node with a point force. Near are the nodes of the elements that touch a corner, and
/// those within a quarter of the body's wall thickness (twice its volume over its skin area) of
/// one.
std::vector<std::uint8_t> singular_corners(const Mesh& mesh, const StaticModel& model) {
  // If a round wall has six elements per turn, its facets meet at 30 degrees at the middle nodes.
  constexpr double kTurn = 40 * std::numbers::pi / 180;
  const std::vector<std::uint8_t> held = held_directions(mesh, model.fixed);
  std::vector<std::uint8_t> corner = singular_nodes(mesh, held, kTurn);
  for (const Load& load : model.loads)
    if (const auto* point = std::get_if<PointForce>(&load))
      corner[static_cast<std::size_t>(point->node)] = 1;
  std::vector<Vec3> corners;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (corner[n])
      corners.push_back(mesh.nodes[n]);
  std::vector<std::uint8_t> near = corner;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    if (std::any_of(nodes.begin(), nodes.end(),
                    [&](int n) { return corner[static_cast<std::size_t>(n)] != 0; }))
      for (const int n : nodes)
        near[static_cast<std::size_t>(n)] = 1;
  }
  const double reach = .5 * volume(mesh) / area(mesh, outer_faces(mesh));
  const Surface skin = surface_of(mesh); // the largest stress is on the skin
  for (const int n : skin.node)
    for (std::size_t c = 0; c < corners.size() && !near[static_cast<std::size_t>(n)]; ++c)
      near[static_cast<std::size_t>(n)] =
          length(mesh.nodes[static_cast<std::size_t>(n)] - corners[c]) < reach;
  return near;
}

/// Draws the sheet from the arrays, which are meanwhile in a file beside it.
void draw_arrays(const std::string& picture, const NpzWriter& npz) {
  const std::string between = picture + ".npz.partial";
  struct Remover {
    const std::string& path;
    ~Remover() {
      std::error_code error;
      std::filesystem::remove(path, error);
    }
  } const remover{between};
  write_npz(between, npz);
  draw_sheet("stress_sheet.py", between, picture);
}

} // namespace

double mean(std::span<const double> values) {
  return std::accumulate(values.begin(), values.end(), 0.) / static_cast<double>(values.size());
}

PictureState picture_of(const Mesh& mesh, const StaticModel& model, const StaticSolution& solution,
                        std::vector<double> von_mises_at_elements) {
  PictureState state;
  state.nodes = mesh.nodes;
  RecoveredStress recovered = recovered_stress(mesh, model.materials, solution.displacement);
  state.von_mises = equivalent_stress(recovered.at_nodes, StressMeasure::von_mises);
  state.error = std::move(recovered.error);
  state.missing_at_elements =
      equivalent_stress(at_middles(mesh, recovered.at_nodes), StressMeasure::von_mises);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    state.missing_at_elements[e] -= von_mises_at_elements[e];
  state.at_elements = std::move(von_mises_at_elements);
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i) {
    const double* u = &solution.displacement[3 * i];
    state.max_displacement = std::max(state.max_displacement, length({u[0], u[1], u[2]}));
  }
  state.volume = volume(mesh);
  const std::vector<std::uint8_t> corners = singular_corners(mesh, model);
  double away = -1;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    if (state.von_mises[n] > state.von_mises[state.peak])
      state.peak = n;
    if (!corners[n] && state.von_mises[n] > away) {
      away = state.von_mises[n];
      state.peak_away = n;
    }
  }
  if (!corners[state.peak])
    state.peak_away.reset();
  return state;
}

void draw_part(const std::string& picture, const StaticModel& model, const DesignSpace& space,
               const Mesh& start, std::span<const PictureState> states,
               const PictureLabels& labels) {
  const std::vector<double>& parameters = labels.parameters;
  const Surface skin = surface_of(start);
  std::vector<std::int32_t> triangles, is_free(space.weights.control_points.size(), 0);
  for (const auto& t : skin.triangles)
    triangles.insert(triangles.end(), t.begin(), t.end());
  for (const int control : space.controls)
    is_free[static_cast<std::size_t>(control)] = 1;
  std::vector<Vec3> moved = space.weights.control_points;
  for (std::size_t p = 0; p < parameters.size(); ++p)
    moved[static_cast<std::size_t>(space.parameters[p].control)][space.parameters[p].axis] +=
        parameters[p];
  std::vector<double> vertices, stresses, numbers;
  for (const PictureState& s : states) {
    for (const int n : skin.node) {
      const Vec3& p = s.nodes[static_cast<std::size_t>(n)];
      vertices.insert(vertices.end(), {p.x, p.y, p.z});
      stresses.push_back(s.von_mises[static_cast<std::size_t>(n)]);
    }
    const auto row = numbers_of(s);
    numbers.insert(numbers.end(), row.begin(), row.end());
  }
  std::string arrows;
  std::vector<double> arrow_rows;
  for (const Arrow& a : arrows_of(start, model)) {
    arrows += (arrows.empty() ? "" : ", ") + files::quoted_json(a.words);
    arrow_rows.insert(arrow_rows.end(), {a.at.x, a.at.y, a.at.z, a.force.x, a.force.y, a.force.z});
  }
  const std::vector<double> constrained = constrained_points(start, model, skin);
  const std::string meta = "{\"title\": " + files::quoted_json(labels.title) +
                           ", \"subtitle\": " + files::quoted_json(labels.subtitle) +
                           ", \"arrows\": [" + arrows + "]" +
                           format(", \"lattice\": [%d, %d, %d]}", space.lattice.points[0],
                                  space.lattice.points[1], space.lattice.points[2]);
  const std::vector<std::uint8_t> meta_bytes(meta.begin(), meta.end());
  const auto controls = coordinates(space.weights.control_points),
             moved_controls = coordinates(moved);
  const std::size_t c = space.weights.control_points.size(), v = skin.node.size();
  NpzWriter npz;
  npz.add("meta", meta_bytes, {meta_bytes.size()});
  npz.add("nodes", vertices, {states.size(), v, 3});
  npz.add("stress", stresses, {states.size(), v});
  npz.add("triangles", triangles, {skin.triangles.size(), 3});
  npz.add("numbers", numbers, {states.size(), 10});
  npz.add("arrows", arrow_rows, {arrow_rows.size() / 6, 6});
  npz.add("held", constrained, {constrained.size() / 3, 3});
  npz.add("controls", controls, {c, 3});
  npz.add("moved_controls", moved_controls, {c, 3});
  npz.add("is_free", is_free, {c});
  npz.add("taylor", labels.taylor, {labels.taylor.size()});
  npz.add("solved", states.back().at_elements, {states.back().at_elements.size()});
  draw_arrays(picture, npz);
}

} // namespace tactus::fem
