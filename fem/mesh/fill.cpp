#include "fem/mesh/fill.hpp"

#include "fem/io/text.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/gmsh_model.hpp"
#include "fem/mesh/remesh.hpp"
#include "fem/mesh/simplify.hpp"

#include <algorithm>
#include <gmsh.h>
#include <optional>
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

/// Adds the volume between the faces of the outer shell and those of each cavity.
void add_volume(const std::vector<std::vector<int>>& faces_of_shell) {
  std::vector<int> loops;
  loops.reserve(faces_of_shell.size());
  for (const auto& faces : faces_of_shell)
    loops.push_back(gmsh::model::geo::addSurfaceLoop(faces));
  gmsh::model::geo::addVolume(loops);
  gmsh::model::geo::synchronize();
}

constexpr std::size_t kMaxTriangles = 60000; ///< most that are filled without remeshing, for 10^6
                                             ///< unknowns
constexpr std::size_t kSimplified = 20000;   ///< above this number, edges are first collapsed in
                                             ///< one pass
constexpr double kMaxVolumeChange = .01;     ///< difference between mesh and surface

/// Fills a closed surface with tet10.
class SurfaceFill {
public:
  SurfaceFill(const Triangles& surface, const LoadChoice& choice)
      : surface_(surface), choice_(choice) {
    double edges = 0;
    for (const auto& t : surface.triangles) {
      const auto at = [&](std::size_t k) { return surface.points[static_cast<std::size_t>(t[k])]; };
      solid_ += dot(at(0), cross(at(1), at(2))) / 6;
      skin_ += .5 * length(cross(at(1) - at(0), at(2) - at(0)));
      edges += length(at(1) - at(0)) + length(at(2) - at(1)) + length(at(0) - at(2));
    }
    const double largest = bounding_box(surface.points).largest();
    target_edge_ =
        choice.sizes ? choice.sizes->largest() : first_size(choice, solid_, skin_, largest);
    mean_edge_ = edges / (3 * static_cast<double>(surface.triangles.size()));
    slivers_ = share_of_slivers(surface, 8);
  }

  [[nodiscard]] Mesh mesh() {
    const bool remesh_surface = choice_.remesh || choice_.sizes || slivers_ > .01 ||
                                mean_edge_ < .6 * target_edge_ || mean_edge_ > 1.6 * target_edge_;
    predict_size(remesh_surface ? 0 : static_cast<double>(surface_.triangles.size()));
    if (!remesh_surface)
      return fill(surface_);
    // Where faces are close together, a coarser surface has less room for deviations.
    for (const auto& [size, deviation_factor] : std::initializer_list<std::pair<double, double>>{
             {1, .1}, {1, .03}, {1, .01}, {.6, .03}, {.35, .03}})
      if (std::optional<Mesh> mesh = try_remeshed(size, deviation_factor))
        return std::move(*mesh);
    if (choice_.sizes) // the original triangles do not have the sizes of the refinement
      throw InputError(reason_.empty() ? "the surface with finer triangles crosses itself"
                                       : reason_);
    if (surface_.triangles.size() > kMaxTriangles)
      throw InputError(reason_.empty()
                           ? format("no coarser surface without crossings was found for its "
                                    "%zu triangles: use a smaller --h",
                                    surface_.triangles.size())
                           : reason_);
    notify("the triangles are not remeshed");
    return fill(surface_);
  }

private:
  void notify(const std::string& sentence) const {
    if (choice_.notify)
      choice_.notify(sentence);
  }
  void predict_size(double triangles) const {
    if (choice_.on_prediction)
      choice_.on_prediction(predicted_mesh_size(choice_, std::abs(solid_), skin_,
                                                bounding_box(surface_.points).size(), target_edge_,
                                                triangles),
                            choice_.notify);
  }

  /// Remeshes the surface with triangles of `size` times the requested edge and fills it. Returns
  /// nullopt if the triangles cross, are too many or cannot be filled.
  [[nodiscard]] std::optional<Mesh> try_remeshed(double size, double deviation_factor) {
    const std::function<double(const Vec3&)> edge = [&, scale = .85 * size](const Vec3& p) {
      return scale * (choice_.sizes ? std::min(target_edge_, choice_.sizes->at(p)) : target_edge_);
    };
    const double deviation = deviation_factor * size * target_edge_;
    const bool large = surface_.triangles.size() > kSimplified;
    Triangles thin = large ? simplified(surface_, edge, .5 * deviation) : Triangles{};
    Triangles even = remeshed(large ? thin : surface_, edge, deviation);
    const bool crossed = crossing(even).has_value();
    if (crossed && large) // the simplified surface does not cross itself
      even = std::move(thin);
    if (even.triangles.size() > kMaxTriangles || (crossed && !large))
      return std::nullopt;
    notify(format("%zu triangles remeshed at %.3g mm: %zu (slivers: %.1f %% before, %.1f %% now)",
                  surface_.triangles.size(), 1e3 * size * target_edge_, even.triangles.size(),
                  100 * slivers_, 100 * share_of_slivers(even, 8)));
    try {
      return fill(even);
    } catch (const TooLarge&) {
      throw;
    } catch (const InputError& refusal) {
      reason_ = refusal.what();
      notify(reason_);
      return std::nullopt;
    }
  }

  /// Fills the triangles with tet10. Refuses a mesh whose volume differs from the surface's.
  [[nodiscard]] Mesh fill(const Triangles& triangles) const {
    predict_size(static_cast<double>(triangles.triangles.size()));
    Session session;
    return session.run("the surface cannot be filled", [&] {
      build_discrete(triangles);
      std::vector<std::vector<int>> faces_of_shell;
      faces_of_shell.reserve(static_cast<std::size_t>(triangles.shells));
      for (int s = 0; s < triangles.shells; ++s)
        faces_of_shell.push_back({s + 1});
      if (choice_.sizes)
        set_sizes(*choice_.sizes, 1);
      else
        set_sizes(target_edge_, {});
      add_volume(faces_of_shell);
      generate(3);
      Mesh mesh = make_quadratic(false, 1);
      check(mesh);
      const double change = volume(mesh) / std::abs(solid_) - 1;
      if (std::abs(change) > kMaxVolumeChange)
        throw InputError(format("the volume changed by %.1f %%", 100 * change));
      return mesh;
    });
  }

  const Triangles& surface_;
  const LoadChoice& choice_;
  double solid_ = 0, skin_ = 0;    ///< m^3, m^2
  double target_edge_, mean_edge_; ///< m
  double slivers_;                 ///< share of the triangles
  std::string reason_;             ///< reason of the last refusal
};

} // namespace

Mesh mesh_surface(const Triangles& surface, const LoadChoice& choice) {
  return SurfaceFill(surface, choice).mesh();
}

} // namespace tactus::fem
