#include "fem/statics/selection.hpp"

#include "fem/statics/face_points.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace tactus::fem {
namespace {

template <class... F> struct Overloaded : F... { using F::operator()...; };
template <class... F> Overloaded(F...) -> Overloaded<F...>; // required by clang 14

using Inside = std::function<bool(std::size_t node)>;

void check_radius(double radius, const char* what) {
  if (!(radius > 0) || !std::isfinite(radius))
    throw InputError(std::string("a selection's ") + what + " has the radius " +
                     std::to_string(radius) + " m, expected above 0");
}

std::string named_sets(const Mesh& mesh) {
  std::string names;
  for (const auto& [name, nodes] : mesh.node_sets)
    names += (names.empty() ? "" : ", ") + name;
  return names.empty() ? "the mesh has none" : "expected one of: " + names;
}

Inside test_of(const Mesh& mesh, const Selection& selection) {
  const double tolerance =
      selection.tolerance_m > 0 ? selection.tolerance_m : 1e-6 * bounding_box(mesh.nodes).largest();
  const auto at = [&mesh](std::size_t n) -> const Vec3& { return mesh.nodes[n]; };
  return std::visit(
      Overloaded{
          [&](const InBox& in) -> Inside {
            for (int k = 0; k < 3; ++k)
              if (!(in.box.low[k] <= in.box.high[k]))
                throw InputError("a selection's box has low above high along " +
                                 std::string(1, "xyz"[k]) + ": expected low <= high");
            return [=](std::size_t n) {
              for (int k = 0; k < 3; ++k)
                if (!(at(n)[k] >= in.box.low[k] - tolerance &&
                      at(n)[k] <= in.box.high[k] + tolerance))
                  return false;
              return true;
            };
          },
          [&](const OnPlane& on) -> Inside {
            const double size = length(on.normal);
            if (!(size > 0) || !std::isfinite(size))
              throw InputError(
                  "a selection's plane has no normal, expected a vector that is not zero");
            const Vec3 normal = (1 / size) * on.normal;
            return
                [=](std::size_t n) { return std::abs(dot(at(n) - on.point, normal)) <= tolerance; };
          },
          [&](const OnSphere& on) -> Inside {
            check_radius(on.radius, "sphere");
            return [=](std::size_t n) {
              const double outside_by = length(at(n) - on.centre) - on.radius;
              return outside_by <= tolerance && (on.solid || outside_by >= -tolerance);
            };
          },
          [&](const OnCylinder& on) -> Inside {
            check_radius(on.radius, "cylinder");
            const double size = length(on.end - on.start);
            if (!(size > 0) || !std::isfinite(size))
              throw InputError("a selection's cylinder has no length, expected two different ends");
            const Vec3 axis = (1 / size) * (on.end - on.start);
            return [=](std::size_t n) {
              const Vec3 arm = at(n) - on.start;
              const double along = dot(arm, axis);
              const double outside_by = length(arm - along * axis) - on.radius;
              return along >= -tolerance && along <= size + tolerance && outside_by <= tolerance &&
                     (on.solid || outside_by >= -tolerance);
            };
          },
          [&](const InNodeSet& in) -> Inside {
            const auto set = mesh.node_sets.find(in.name);
            if (set == mesh.node_sets.end())
              throw InputError("the mesh has no node set " + in.name + ": " + named_sets(mesh));
            std::vector<std::uint8_t> marked(mesh.nodes.size(), 0);
            for (const int n : set->second)
              marked[static_cast<std::size_t>(n)] = 1;
            return [marked = std::move(marked)](std::size_t n) { return marked[n] != 0; };
          }},
      selection.region);
}

const char* region_name(const Selection& selection) {
  static constexpr std::array kNames{"box", "plane", "sphere", "cylinder", "node set"};
  return kNames[selection.region.index()];
}

} // namespace

std::vector<int> select_nodes(const Mesh& mesh, const Selection& selection) {
  const Inside inside = test_of(mesh, selection);
  std::vector<int> found;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (inside(n))
      found.push_back(static_cast<int>(n));
  if (found.empty())
    throw InputError(std::string("no node of the mesh lies in the selected ") +
                     region_name(selection));
  return found;
}

std::vector<MeshFace> select_faces(const Mesh& mesh, const Selection& selection) {
  const Inside inside = test_of(mesh, selection);
  std::vector<MeshFace> found;
  for (const MeshFace& f : outer_faces(mesh)) {
    const FaceNodes nodes = face_nodes(mesh, f);
    if (std::all_of(nodes.node.begin(),
                    nodes.node.begin() + static_cast<std::ptrdiff_t>(nodes.count), inside))
      found.push_back(f);
  }
  if (found.empty())
    throw InputError(std::string("no face of the skin lies in the selected ") +
                     region_name(selection));
  return found;
}

std::vector<int> nodes_of_faces(const Mesh& mesh, std::span<const MeshFace> given) {
  std::vector<int> nodes;
  for (const MeshFace& f : given) {
    const FaceNodes own = face_nodes(mesh, f);
    for (std::size_t a = 0; a < own.count; ++a)
      nodes.push_back(static_cast<int>(own.node[a]));
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

} // namespace tactus::fem
