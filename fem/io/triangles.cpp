#include "fem/io/triangles.hpp"

#include "fem/io/safe_file.hpp"
#include "fem/io/text.hpp"
#include "fem/mesh/ears.hpp"
#include "files/mesh_file.hpp"

#include <limits>
#include <numbers>

namespace tactus::fem {
namespace {

/// Adds a polygon's triangles.
void add_polygon(std::span<const std::uint32_t> polygon, int group, Triangles& out) {
  const auto index = [&](std::size_t k) { return static_cast<int>(polygon[k]); };
  if (polygon.size() == 3) {
    out.triangles.push_back({index(0), index(1), index(2)});
    out.group.push_back(group);
    return;
  }
  std::vector<Vec3> corners;
  corners.reserve(polygon.size());
  for (const std::uint32_t p : polygon)
    corners.push_back(out.points[p]);
  for (const auto& ear : clip_ears(corners)) {
    std::array<int, 3> triangle{};
    for (std::size_t k = 0; k < 3; ++k)
      triangle[k] = index(static_cast<std::size_t>(ear[k]));
    out.triangles.push_back(triangle);
    out.group.push_back(group);
  }
}

} // namespace

std::string near_position(const Vec3& p) {
  return format(" near (%.4g, %.4g, %.4g) mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
}

std::string triangle_location(const Triangles& t, std::size_t i) {
  return "triangle " + std::to_string(i + 1) + near_position(t.corner(i, 0));
}

Triangles triangles_of(const std::string& path, std::string_view bytes, double unit) {
  files::PolygonMesh mesh = files::read_mesh(
      bytes, lower(path).ends_with(".obj") ? files::MeshFormat::kObj : files::MeshFormat::kStl,
      {.max_face_corners = kMaxEarCorners});
  if (!mesh.free_form.empty())
    throw InputError(path + " " + mesh.free_form + ": export the body as polygons, or as STEP");
  if (!mesh.error.empty())
    throw InputError(path + (mesh.error.starts_with("triangle") ? ": " : " ") + mesh.error);
  Triangles out;
  out.points.reserve(mesh.points.size());
  for (const Vec3& p : mesh.points)
    out.points.push_back({unit * p.x, unit * p.y, unit * p.z});
  out.triangles.reserve(mesh.polygons());
  out.group.reserve(mesh.polygons());
  for (std::size_t i = 0; i < mesh.polygons(); ++i)
    add_polygon(mesh.polygon(i), static_cast<int>(mesh.group_of(i)), out);
  out.groups = std::move(mesh.groups);
  return out;
}

Triangles read_triangles(const std::string& path, double unit) {
  return triangles_of(path, read_bytes(path, std::numeric_limits<std::uint64_t>::max()), unit);
}

double share_of_slivers(const Triangles& t, double degrees) {
  const double limit = std::cos(degrees * std::numbers::pi / 180);
  std::size_t slivers = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 p = t.corner(i, k), a = t.corner(i, k + 1) - p, b = t.corner(i, k + 2) - p;
      if (dot(a, b) > limit * length(a) * length(b)) {
        ++slivers;
        break;
      }
    }
  return static_cast<double>(slivers) / static_cast<double>(t.triangles.size());
}

} // namespace tactus::fem
