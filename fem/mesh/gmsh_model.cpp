#include "fem/mesh/gmsh_model.hpp"
#include "fem/io/gmsh_elements.hpp"

#include <algorithm>
#include <gmsh.h>
#include <new>
#include <numbers>
#include <optional>
#include <set>
#include <tuple>
#include <unordered_map>

namespace tactus::fem {

void generate(int dimension) {
  gmsh::logger::stop();
  gmsh::logger::start();                              // forgets earlier errors
  gmsh::option::setNumber("General.AbortOnError", 1); // ends the mesh without throwing
  gmsh::model::mesh::generate(dimension);
  gmsh::option::setNumber("General.AbortOnError", 2);
  std::vector<std::string> log;
  gmsh::logger::get(log);
  for (const std::string& line : log)
    if (line.starts_with("Error"))
      throw InputError(line);
}

/// Converts gmsh's present mesh; each volume is a region.
Mesh import_mesh(double unit, bool face_sets) {
  Mesh mesh;
  std::vector<std::size_t> tags;
  std::vector<double> coordinates, parameters;
  gmsh::model::mesh::getNodes(tags, coordinates, parameters);
  std::unordered_map<std::size_t, int> number;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    number[tags[i]] = static_cast<int>(i);
    mesh.nodes.push_back(
        {unit * coordinates[3 * i], unit * coordinates[3 * i + 1], unit * coordinates[3 * i + 2]});
  }
  mesh.regions.clear();
  gmsh::vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  for (const auto& [dimension, volume] : volumes) {
    std::string name = volumes.size() == 1 ? "body" : "volume" + std::to_string(volume);
    std::vector<int> groups;
    gmsh::model::getPhysicalGroupsForEntity(dimension, volume, groups);
    if (!groups.empty())
      gmsh::model::getPhysicalName(dimension, groups.front(), name);
    const auto at = std::find(mesh.regions.begin(), mesh.regions.end(), name);
    const int region = static_cast<int>(at - mesh.regions.begin());
    if (at == mesh.regions.end())
      mesh.regions.push_back(name);
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> elements, nodes;
    gmsh::model::mesh::getElements(types, elements, nodes, dimension, volume);
    for (std::size_t t = 0; t < types.size(); ++t) {
      const GmshElement* const type = gmsh_element(types[t]);
      if (!type || !type->shape)
        throw InputError("element " + std::to_string(elements[t][0]) + " is a " +
                         (type ? type->name : "shape of unknown type") +
                         ", expected tet10, wedge15 or hex20");
      const auto count = static_cast<std::size_t>(type->nodes);
      for (std::size_t e = 0; e < elements[t].size(); ++e) {
        std::vector<int> own(count);
        for (std::size_t i = 0; i < count; ++i)
          own[i] = number.at(nodes[t][e * count + static_cast<std::size_t>(type->from[i])]);
        mesh.add(*type->shape, own, region);
      }
    }
  }
  if (mesh.elements.empty())
    throw InputError("the mesh holds no volume element: expected tet10, wedge15 or hex20");
  gmsh::vectorpair faces;
  if (face_sets)
    gmsh::model::getEntities(faces, 2);
  for (const auto& [dimension, face] : faces) {
    gmsh::model::mesh::getNodes(tags, coordinates, parameters, dimension, face, true, false);
    auto& set = mesh.node_sets[face_set(face)];
    for (const std::size_t tag : tags)
      set.push_back(number.at(tag));
    std::sort(set.begin(), set.end());
    set.erase(std::unique(set.begin(), set.end()), set.end());
  }
  drop_unused_nodes(mesh);
  return mesh;
}

namespace {

/// A triangle of the surface mesh.
struct Facet {
  std::array<std::size_t, 3> node;
};

using Positions = std::unordered_map<std::size_t, Vec3>; ///< positions by the node's tag

Positions node_positions() {
  Positions position;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i)
    position[tags[i]] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
  return position;
}

/// The facets of the volumes' boundary, turned outward.
std::vector<Facet> boundary_facets(const gmsh::vectorpair& volumes, Positions& position) {
  std::vector<Facet> facets;
  double whole = 0;
  gmsh::vectorpair faces;
  gmsh::model::getBoundary(volumes, faces, true, true);
  for (const auto& [dimension, face] : faces) {
    std::vector<std::size_t> elements, nodes;
    gmsh::model::mesh::getElementsByType(2, elements, nodes, std::abs(face));
    for (std::size_t e = 0; e < elements.size(); ++e) {
      Facet f{{nodes[3 * e], nodes[3 * e + 1], nodes[3 * e + 2]}};
      if (face < 0)
        std::swap(f.node[0], f.node[1]);
      whole += dot(position[f.node[0]], cross(position[f.node[1]], position[f.node[2]])) / 6;
      facets.push_back(f);
    }
  }
  if (whole < 0)
    for (Facet& f : facets)
      std::swap(f.node[0], f.node[1]);
  return facets;
}

} // namespace

std::vector<double> concave_curves() {
  Positions position = node_positions();
  gmsh::vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  if (volumes.size() != 1)
    return {}; // inner faces between regions would look like edges
  std::map<std::array<std::size_t, 2>, std::vector<std::array<std::size_t, 3>>> at_edge;
  for (const Facet& f : boundary_facets(volumes, position)) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t a = f.node[k], b = f.node[(k + 1) % 3];
      at_edge[{std::min(a, b), std::max(a, b)}].push_back(f.node);
    }
  }
  std::vector<double> concave;
  gmsh::vectorpair curves;
  gmsh::model::getEntities(curves, 1);
  const double limit = std::sin(20 * std::numbers::pi / 180);
  for (const auto& [dimension, curve] : curves) {
    std::vector<std::size_t> elements, nodes;
    gmsh::model::mesh::getElementsByType(1, elements, nodes, curve);
    std::size_t edge_count = 0, concave_count = 0;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const std::size_t a = nodes[2 * e], b = nodes[2 * e + 1];
      const auto owners = at_edge.find({std::min(a, b), std::max(a, b)});
      if (owners == at_edge.end() || owners->second.size() != 2)
        continue;
      const auto& [f, g] = std::tie(owners->second[0], owners->second[1]);
      const Vec3 normal = cross(position[f[1]] - position[f[0]], position[f[2]] - position[f[0]]);
      std::size_t far = g[0];
      for (const std::size_t n : g)
        if (n != a && n != b)
          far = n;
      const Vec3 to_far = position[far] - .5 * (position[a] + position[b]);
      ++edge_count;
      concave_count += dot(normal, to_far) > limit * length(normal) * length(to_far);
    }
    if (edge_count > 0 && 2 * concave_count > edge_count)
      concave.push_back(curve);
  }
  return concave;
}

double first_size(const LoadChoice& choice, double volume, double skin, double largest) {
  if (choice.h > 0)
    return choice.h;
  const double wall = 2 * std::abs(volume) / skin;
  const double target_size =
      choice.size_for ? choice.size_for(std::abs(volume), skin, largest) : wall;
  return std::max(std::min({target_size, largest / 4, 2 * wall}),
                  std::sqrt(4 / std::sqrt(3.0) * skin / 60000));
}

void set_sizes(const SizeField& sizes, double unit, double finer) {
  const double scale = finer / unit;
  gmsh::option::setNumber("Mesh.CharacteristicLengthMax", scale * sizes.largest());
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", .5 * scale * sizes.smallest());
  gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 0);
  gmsh::option::setNumber("Mesh.CharacteristicLengthExtendFromBoundary", 0);
  const auto size_at = [&sizes, unit, scale](int, int, double x, double y, double z, auto...) {
    return scale * sizes.at({unit * x, unit * y, unit * z});
  };
  gmsh::model::mesh::setSizeCallback(size_at); // gmsh 4.9 and later also pass gmsh's own size
}

MeshSize predicted_mesh_size(const LoadChoice& choice, double volume, double skin, const Vec3& box,
                             double h, double faces) {
  if (!choice.sizes)
    return predict_tetrahedra(volume, skin, box, h, faces);
  // If the model has several bodies, the field predicts the elements of all of them, so the
  // prediction for one body is limited to that with the smallest size.
  const MeshSize even = predict_tetrahedra(volume, skin, box, choice.sizes->smallest());
  return scaled(even, std::min(even.elements, choice.sizes->elements));
}

void set_sizes(double h, const std::vector<double>& concave) {
  gmsh::option::setNumber("Mesh.CharacteristicLengthMax", h);
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin",
                          h / 6); // smaller fillets are not resolved
  if (concave.empty())
    return;
  using namespace gmsh::model::mesh;
  const int distance = field::add("Distance"), grade = field::add("Threshold");
  field::setNumbers(distance, "CurvesList", concave);
  field::setNumber(distance, "NumPointsPerCurve", 200);
  field::setNumber(grade, "InField", distance);
  field::setNumber(grade, "SizeMin", h / 6);
  field::setNumber(grade, "SizeMax", h);
  field::setNumber(grade, "DistMin", h / 12);
  field::setNumber(grade, "DistMax", 2 * h);
  field::setAsBackgroundMesh(grade);
}

Mesh make_quadratic(bool curved, double unit, bool face_sets) {
  using namespace gmsh::model::mesh;
  // gmsh's own repair ("HighOrder") is not used, since it takes minutes if fillets are smaller than
  // the elements.
  gmsh::option::setNumber("Mesh.SecondOrderLinear", curved ? 0 : 1);
  setOrder(2);
  Mesh mesh = import_mesh(unit, face_sets);
  if (curved)
    straighten_inverted(mesh);
  return mesh;
}

} // namespace tactus::fem
