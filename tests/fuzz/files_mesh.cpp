// STL and OBJ: corners exist, points are finite, limits hold, whatever the format is taken for.
#include "files/mesh_file.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <algorithm>

using namespace tactus::files;
using tactus::Vec3;
using tactus::fuzz::check;

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  const std::string_view bytes(reinterpret_cast<const char*>(input.data()), input.size());
  constexpr std::size_t kTriangles = 40;
  for (const MeshFormat format : {MeshFormat::kByContent, MeshFormat::kStl, MeshFormat::kObj}) {
    const PolygonMesh mesh = read_mesh(bytes, format, {.max_triangles = kTriangles});
    check(std::all_of(mesh.points.begin(), mesh.points.end(),
                      [](const Vec3& p) { return is_finite(p); }),
          "a point is not finite");
    check(mesh.error.find('\n') == std::string::npos, "an error has more than one line");
    if (!mesh.error.empty())
      continue;
    check(std::all_of(mesh.corner.begin(), mesh.corner.end(),
                      [&](std::uint32_t c) { return c < mesh.points.size(); }),
          "a corner is none of the points");
    const auto triangles = fan_triangles(mesh);
    check(!triangles.empty() && triangles.size() <= kTriangles, "the limit does not hold");
    for (std::size_t i = 0; i < mesh.polygons(); ++i) {
      check(mesh.polygon(i).size() >= 3, "a polygon has no three corners");
      check(mesh.group_of(i) < std::max<std::size_t>(mesh.groups.size(), 1), "a group has no name");
    }
  }
}
