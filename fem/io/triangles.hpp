#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// A vertex, triangle or shell number as an index of the standard library's containers.
[[nodiscard]] constexpr std::size_t at(int i) noexcept { return static_cast<std::size_t>(i); }

/// A surface of triangles. Files give an unconnected soup; weld() and find_shells() (fem/mesh) make
/// closed shells from this soup, oriented outward.
struct Triangles {
  std::vector<Vec3> points; ///< m
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> group;          ///< for each triangle, its solid or object of the file
  std::vector<std::string> groups; ///< names of these solids or objects
  std::vector<int> shell;          ///< the connected piece of each triangle
  int shells = 0;

  [[nodiscard]] Vec3 corner(std::size_t triangle, std::size_t k) const {
    return points[static_cast<std::size_t>(triangles[triangle][k % 3])];
  }
  /// Normal of a triangle, as long as twice its area (m^2).
  [[nodiscard]] Vec3 normal(std::size_t triangle) const {
    const Vec3 a = corner(triangle, 0);
    return cross(corner(triangle, 1) - a, corner(triangle, 2) - a);
  }
};

/// Reads an STL (text or binary, recognised by its content) or OBJ file without repair
/// (files/mesh_file.hpp). Polygons are triangulated by ear clipping, lengths multiplied by `unit`.
/// Refuses an unreadable file, naming its line or triangle.
[[nodiscard]] Triangles read_triangles(const std::string& path, double unit);
/// As read_triangles(), from a file's bytes. OBJ is recognised by the ending of `path`, which also
/// appears in error texts.
[[nodiscard]] Triangles triangles_of(const std::string& path, std::string_view bytes, double unit);

/// A text such as " near (1, 2, 3) mm", for sentences to the user.
[[nodiscard]] std::string near_position(const Vec3&);

/// A text such as "triangle 17 near (1, 2, 3) mm", counted from one, for refusals.
[[nodiscard]] std::string triangle_location(const Triangles&, std::size_t triangle);

/// Share of triangles with an angle below `degrees`.
[[nodiscard]] double share_of_slivers(const Triangles&, double degrees);

} // namespace tactus::fem
