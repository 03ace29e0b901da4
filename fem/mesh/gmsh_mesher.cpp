#include "fem/mesh/gmsh_mesher.hpp"

#include "fem/io/cad_format.hpp"
#include "fem/io/gmsh_elements.hpp"
#include "fem/io/words.hpp"
#include "fem/mesh/remesh.hpp"

#include <algorithm>
#include <gmsh.h>
#include <numbers>
#include <optional>
#include <set>
#include <unordered_map>

namespace tactus::fem {
namespace {

/// gmsh from initialize() to finalize(), its errors as refusals.
class Session {
public:
  Session() {
    gmsh::initialize(0, nullptr, false); // no ~/.gmshrc, no ~/.gmsh-options
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
    gmsh::option::setNumber("Mesh.RandomSeed", 1);
    gmsh::logger::start();
  }
  ~Session() { gmsh::finalize(); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;

  template <class Work> auto run(const std::string& what, Work&& work) {
    try {
      return work();
    } catch (const Refusal&) {
      throw;
    } catch (const std::exception& error) {
      throw Refusal(what + ": " + complaint(error.what()));
    } catch (...) {
      throw Refusal(what + ": " + complaint("gmsh failed"));
    }
  }

private:
  /// gmsh's last error, or what is known otherwise.
  static std::string complaint(std::string reason) {
    std::vector<std::string> log;
    gmsh::logger::get(log);
    for (const std::string& line : log)
      if (line.starts_with("Error"))
        reason = line;
    return reason;
  }
};

/// The mesh that gmsh holds; each volume is a region.
Mesh take_over(double unit) {
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
    const std::string name = volumes.size() == 1 ? "body" : "volume" + std::to_string(volume);
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
        throw Refusal("element " + std::to_string(elements[t][0]) + " is a " +
                      (type ? type->name : "type that is not known") +
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
    throw Refusal("the mesh holds no volume element: expected tet10, wedge15 or hex20");
  drop_unused_nodes(mesh);
  return mesh;
}

/// Triangles of the surface mesh, turned outward with the volumes' boundaries.
struct Facet {
  std::array<std::size_t, 3> node;
};

/// Model curves where the body turns inward. Compares the two facets at each mesh edge on a curve:
/// where the far corner of one rises above the outward plane of the other, the angle is concave.
std::vector<double> concave_curves() {
  std::unordered_map<std::size_t, Vector3> place;
  std::vector<std::size_t> tags;
  std::vector<double> xyz, parameters;
  gmsh::model::mesh::getNodes(tags, xyz, parameters);
  for (std::size_t i = 0; i < tags.size(); ++i)
    place[tags[i]] = {xyz[3 * i], xyz[3 * i + 1], xyz[3 * i + 2]};
  std::map<std::array<std::size_t, 2>, std::vector<std::size_t>> far_corners; // by oriented use
  gmsh::vectorpair volumes;
  gmsh::model::getEntities(volumes, 3);
  if (volumes.size() != 1)
    return {}; // inner faces between regions would look like edges
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
      whole += dot(place[f.node[0]], cross(place[f.node[1]], place[f.node[2]])) / 6;
      facets.push_back(f);
    }
  }
  std::map<std::array<std::size_t, 2>, std::vector<std::array<std::size_t, 3>>> at_edge;
  for (Facet& f : facets) {
    if (whole < 0)
      std::swap(f.node[0], f.node[1]);
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
    std::size_t seen = 0, inward = 0;
    for (std::size_t e = 0; e < elements.size(); ++e) {
      const std::size_t a = nodes[2 * e], b = nodes[2 * e + 1];
      const auto owners = at_edge.find({std::min(a, b), std::max(a, b)});
      if (owners == at_edge.end() || owners->second.size() != 2)
        continue;
      const auto& [f, g] = std::tie(owners->second[0], owners->second[1]);
      const Vector3 normal = cross(place[f[1]] - place[f[0]], place[f[2]] - place[f[0]]);
      std::size_t far = g[0];
      for (const std::size_t n : g)
        if (n != a && n != b)
          far = n;
      const Vector3 away = place[far] - .5 * (place[a] + place[b]);
      ++seen;
      inward += dot(normal, away) > limit * length(normal) * length(away);
    }
    if (seen > 0 && 2 * inward > seen)
      concave.push_back(curve);
  }
  return concave;
}

/// A size for a body nobody gave one for, from its largest side, its volume over its skin (half a
/// wall's thickness), and the skin: 6000 triangles or so, some 60 thousand unknowns, are enough.
double natural_size(double largest, double volume, double skin) {
  const double wall = 2 * std::abs(volume) / skin;
  return std::max(std::min(largest / 12, std::max(wall / 1.5, largest / 40)),
                  std::sqrt(4 / std::sqrt(3.0) * skin / 3000));
}

void set_sizes(double h, const std::vector<double>& concave) {
  gmsh::option::setNumber("Mesh.CharacteristicLengthMax", h);
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", h / 6); // small fillets wait
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

bool sound(const Mesh& mesh) {
  try {
    check(mesh);
    return true;
  } catch (const Refusal&) {
    return false;
  }
}

/// Second order, sides curved where no element turns inside out: else optimised, else straight.
Mesh make_quadratic(bool curved, double unit) {
  using namespace gmsh::model::mesh;
  gmsh::option::setNumber("Mesh.SecondOrderLinear", curved ? 0 : 1);
  setOrder(2);
  Mesh mesh = take_over(unit);
  if (!curved || sound(mesh))
    return mesh;
  optimize("HighOrder");
  mesh = take_over(unit);
  if (sound(mesh))
    return mesh;
  setOrder(1);
  return make_quadratic(false, unit);
}

/// Fillets the one volume's concave curves; returns those that are left to be graded: none.
std::vector<double> round_off(const gmsh::vectorpair& volumes, const std::vector<double>& concave,
                              double radius) {
  if (volumes.size() != 1)
    throw Refusal("--fillet rounds the edges of one solid, the file holds " +
                  std::to_string(volumes.size()));
  if (concave.empty())
    throw Refusal("--fillet: the body has no concave edge to round");
  std::vector<int> curves;
  curves.reserve(concave.size());
  for (const double curve : concave)
    curves.push_back(static_cast<int>(curve));
  gmsh::model::mesh::clear();
  gmsh::vectorpair rounded;
  try {
    gmsh::model::occ::fillet({volumes[0].second}, curves, {radius}, rounded, true);
  } catch (...) { // what gmsh throws is no exception of the library
    throw Refusal(format("--fillet: a radius of %g of the file's units does not fit the concave "
                         "edges",
                         radius));
  }
  gmsh::model::occ::synchronize();
  gmsh::option::setNumber("Mesh.CharacteristicLengthMin", radius / 3);
  return {};
}

} // namespace

Mesh mesh_cad(const std::string& path, const LoadChoice& choice) {
  Session session;
  return session.run(path + " cannot be meshed", [&] {
    gmsh::vectorpair shapes;
    gmsh::model::occ::importShapes(path, shapes, true, cad_format(path)); // never a script
    gmsh::model::occ::synchronize();
    gmsh::vectorpair volumes;
    gmsh::model::getEntities(volumes, 3);
    if (volumes.empty())
      throw Refusal(path + " holds no solid: expected one at least");
    if (volumes.size() > 1) { // touching solids share their faces
      gmsh::vectorpair all;
      std::vector<gmsh::vectorpair> map;
      gmsh::model::occ::fragment({volumes[0]}, {volumes.begin() + 1, volumes.end()}, all, map);
      gmsh::model::occ::synchronize();
      gmsh::model::getEntities(volumes, 3);
    }
    double solid = 0, skin = 0;
    for (const auto& [dimension, tag] : volumes) {
      double mass = 0;
      gmsh::model::occ::getMass(dimension, tag, mass);
      solid += mass;
    }
    gmsh::vectorpair faces;
    gmsh::model::getBoundary(volumes, faces, true, false);
    for (const auto& [dimension, tag] : faces) {
      double mass = 0;
      gmsh::model::occ::getMass(dimension, std::abs(tag), mass);
      skin += mass;
    }
    Box box;
    gmsh::model::getBoundingBox(-1, -1, box.low.x, box.low.y, box.low.z, box.high.x, box.high.y,
                                box.high.z);
    const double unit = choice.unit > 0 ? choice.unit : 1e-3;
    const double h = choice.coarser *
                     (choice.h > 0 ? choice.h / unit : natural_size(box.largest(), solid, skin));
    gmsh::option::setNumber("Mesh.CharacteristicLengthFromCurvature", 1);
    gmsh::option::setNumber("Mesh.MinimumElementsPerTwoPi", 12); // curved: 1e-4 of the radius
    set_sizes(h, {});
    std::vector<double> concave;
    if (choice.grade_concave || choice.fillet > 0) {
      gmsh::model::mesh::generate(2);
      concave = concave_curves();
      if (choice.fillet > 0)
        concave = round_off(volumes, concave, choice.fillet / unit);
      if (!concave.empty()) {
        if (choice.say)
          choice.say(std::to_string(concave.size()) + " concave edges, graded");
        gmsh::model::mesh::clear();
        set_sizes(h, concave);
      }
    }
    gmsh::model::mesh::generate(3);
    return make_quadratic(choice.curved, unit);
  });
}

namespace {

void build_discrete(const Triangles& surface) {
  gmsh::model::add("surface");
  std::vector<std::size_t> node_tags(surface.points.size());
  std::vector<double> coordinates;
  for (std::size_t i = 0; i < surface.points.size(); ++i) {
    node_tags[i] = i + 1;
    for (int k = 0; k < 3; ++k)
      coordinates.push_back(surface.points[i][k]);
  }
  std::vector<std::set<std::size_t>> used(static_cast<std::size_t>(surface.shells));
  std::vector<std::vector<std::size_t>> nodes(used.size());
  for (std::size_t i = 0; i < surface.triangles.size(); ++i)
    for (const int p : surface.triangles[i]) {
      const auto shell = static_cast<std::size_t>(surface.shell[i]);
      used[shell].insert(static_cast<std::size_t>(p));
      nodes[shell].push_back(static_cast<std::size_t>(p) + 1);
    }
  for (std::size_t s = 0; s < used.size(); ++s) {
    const int tag = gmsh::model::addDiscreteEntity(2, static_cast<int>(s) + 1);
    std::vector<std::size_t> tags;
    std::vector<double> xyz;
    for (const std::size_t p : used[s]) {
      tags.push_back(p + 1);
      xyz.insert(xyz.end(), coordinates.begin() + static_cast<std::ptrdiff_t>(3 * p),
                 coordinates.begin() + static_cast<std::ptrdiff_t>(3 * p + 3));
    }
    gmsh::model::mesh::addNodes(2, tag, tags, xyz);
    gmsh::model::mesh::addElementsByType(tag, 2, {}, nodes[s]);
  }
}

/// The volume between the outer shell's faces and those of each cavity.
void add_volume(const std::vector<std::vector<int>>& faces_of_shell) {
  std::vector<int> loops;
  loops.reserve(faces_of_shell.size());
  for (const auto& faces : faces_of_shell)
    loops.push_back(gmsh::model::geo::addSurfaceLoop(faces));
  gmsh::model::geo::addVolume(loops);
  gmsh::model::geo::synchronize();
}

} // namespace

Mesh mesh_surface(const Triangles& surface, const LoadChoice& choice) {
  double solid = 0, skin = 0, edges = 0;
  for (const auto& t : surface.triangles) {
    const auto at = [&](std::size_t k) { return surface.points[static_cast<std::size_t>(t[k])]; };
    solid += dot(at(0), cross(at(1), at(2))) / 6;
    skin += .5 * length(cross(at(1) - at(0), at(2) - at(0)));
    edges += length(at(1) - at(0)) + length(at(2) - at(1)) + length(at(0) - at(2));
  }
  const double largest = bounding_box(surface.points).largest();
  const double wanted =
      choice.coarser * (choice.h > 0 ? choice.h : natural_size(largest, solid, skin));
  const double mean_edge = edges / (3 * static_cast<double>(surface.triangles.size()));
  const double slivers = share_of_slivers(surface, 8);
  const bool fine = choice.h > 0 ? mean_edge < .6 * wanted : surface.triangles.size() > 9000;
  const bool renew = choice.remesh || slivers > .01 || fine || mean_edge > 1.6 * wanted;
  const auto fill = [&](const Triangles& triangles) {
    Session session;
    return session.run("the surface cannot be filled", [&] {
      build_discrete(triangles);
      std::vector<std::vector<int>> faces_of_shell;
      faces_of_shell.reserve(static_cast<std::size_t>(triangles.shells));
      for (int s = 0; s < triangles.shells; ++s)
        faces_of_shell.push_back({s + 1});
      set_sizes(wanted, {});
      add_volume(faces_of_shell);
      gmsh::model::mesh::generate(3);
      Mesh mesh = make_quadratic(false, 1);
      check(mesh);
      const double change = volume(mesh) / std::abs(solid) - 1;
      if (std::abs(change) > .05)
        throw Refusal(format("the volume changed by %.1f %%", 100 * change));
      return mesh;
    });
  };
  if (!renew)
    return fill(surface);
  const auto say = [&](const std::string& sentence) {
    if (choice.say)
      choice.say(sentence);
  };
  // Faces that lie close together leave less room for a coarser surface between them.
  for (const double away : {.1, .03, .01}) {
    const Triangles even = remeshed(surface, .85 * wanted, away * wanted);
    if (crossing(even))
      continue;
    say(format("%zu triangles renewed at %.3g mm: %zu (%.1f %% were slivers, %.1f %% are)",
               surface.triangles.size(), 1e3 * wanted, even.triangles.size(), 100 * slivers,
               100 * share_of_slivers(even, 8)));
    try {
      return fill(even);
    } catch (const Refusal& refusal) {
      say(refusal.what());
    }
  }
  say("the triangles are kept as they are");
  return fill(surface);
}

} // namespace tactus::fem
