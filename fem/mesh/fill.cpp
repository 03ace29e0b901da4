#include "fem/mesh/fill.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/remesh.hpp"
#include "fem/mesh/simplify.hpp"

#include <algorithm>
#include <gmsh.h>
#include <set>

namespace tactus::fem {
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

namespace {

constexpr std::size_t kMaxTriangles = 60000; ///< that are filled as they are: 10^6 unknowns
constexpr std::size_t kSimplified = 20000;   ///< beyond that edges collapse in one go first
constexpr double kMaxVolumeChange = .01;     ///< of the mesh against its surface

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
  const double target_edge =
      choice.sizes ? choice.sizes->largest() : first_size(choice, solid, skin, largest);
  const auto size_at = [&](const Vector3& p) {
    return choice.sizes ? std::min(target_edge, choice.sizes->at(p)) : target_edge;
  };
  const double mean_edge = edges / (3 * static_cast<double>(surface.triangles.size()));
  const double slivers = share_of_slivers(surface, 8);
  const bool remesh_surface = choice.remesh || choice.sizes || slivers > .01 ||
                              mean_edge < .6 * target_edge || mean_edge > 1.6 * target_edge;
  const auto predict_size = [&](double triangles) {
    if (choice.on_prediction)
      choice.on_prediction(predicted_mesh_size(choice, std::abs(solid), skin,
                                               bounding_box(surface.points).size(), target_edge,
                                               triangles),
                           choice.notify);
  };
  predict_size(remesh_surface ? 0 : static_cast<double>(surface.triangles.size()));
  const auto fill = [&](const Triangles& triangles) {
    predict_size(static_cast<double>(triangles.triangles.size()));
    Session session;
    return session.run("the surface cannot be filled", [&] {
      build_discrete(triangles);
      std::vector<std::vector<int>> faces_of_shell;
      faces_of_shell.reserve(static_cast<std::size_t>(triangles.shells));
      for (int s = 0; s < triangles.shells; ++s)
        faces_of_shell.push_back({s + 1});
      if (choice.sizes)
        set_sizes(*choice.sizes, 1);
      else
        set_sizes(target_edge, {});
      add_volume(faces_of_shell);
      generate(3);
      Mesh mesh = make_quadratic(false, 1);
      check(mesh);
      const double change = volume(mesh) / std::abs(solid) - 1;
      if (std::abs(change) > kMaxVolumeChange)
        throw InputError(format("the volume changed by %.1f %%", 100 * change));
      return mesh;
    });
  };
  if (!remesh_surface)
    return fill(surface);
  const auto notify = [&](const std::string& sentence) {
    if (choice.notify)
      choice.notify(sentence);
  };
  // Faces that lie close together leave less room for a coarser surface between them.
  std::string reason;
  for (const auto& [size, deviation_factor] : std::initializer_list<std::pair<double, double>>{
           {1, .1}, {1, .03}, {1, .01}, {.6, .03}, {.35, .03}}) {
    const std::function<double(const Vector3&)> edge = [&, scale = .85 * size](const Vector3& p) {
      return scale * size_at(p);
    };
    const double deviation = deviation_factor * size * target_edge;
    const bool large = surface.triangles.size() > kSimplified;
    Triangles thin = large ? simplified(surface, edge, .5 * deviation) : Triangles{};
    Triangles even = remeshed(large ? thin : surface, edge, deviation);
    const bool crossed = crossing(even).has_value();
    if (crossed && large) // which the simplified surface does not
      even = std::move(thin);
    if (even.triangles.size() > kMaxTriangles || (crossed && !large))
      continue;
    notify(format("%zu triangles renewed at %.3g mm: %zu (%.1f %% were slivers, %.1f %% are)",
                  surface.triangles.size(), 1e3 * size * target_edge, even.triangles.size(),
                  100 * slivers, 100 * share_of_slivers(even, 8)));
    try {
      return fill(even);
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      reason = refusal.what();
      notify(reason);
    }
  }
  if (choice.sizes) // the triangles as they are would not be what the refinement asks for
    throw InputError(reason.empty() ? "the surface crosses itself in the finer triangles" : reason);
  if (surface.triangles.size() > kMaxTriangles)
    throw InputError(reason.empty()
                         ? format("no coarser surface without crossings was found for its "
                                  "%zu triangles; give a smaller --h",
                                  surface.triangles.size())
                         : reason);
  notify("the triangles are kept as they are");
  return fill(surface);
}

} // namespace tactus::fem
