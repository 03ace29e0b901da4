#include "externals/phantom/scene/scene_shape.hpp"

#include "core/haptic/scene/triangle_mesh.hpp"
#include "files/file_bytes.hpp"
#include "files/mesh_file.hpp"

namespace tactus::phantom {
namespace {

using haptic::Rotation;

constexpr std::size_t kMaxTriangles = 4'000'000; // maximum of a mesh that can be felt

constexpr Range direction(std::string_view name) { return {name, "", -1e6, 1e6}; }
constexpr Range length(std::string_view name) { return {name, "mm", 0.01, kMaxCoordinate_mm}; }

ShapeChoice refused(std::string sentence) {
  ShapeChoice choice;
  choice.refusal = std::move(sentence);
  return choice;
}

template <std::size_t N>
std::string read(Words words, const Range (&ranges)[N], double (&values)[N]) {
  if (words.size() > N)
    return "has more than " + std::to_string(N) + " numbers";
  return read_numbers(words, ranges, values);
}

ShapeChoice plane(Words words) {
  constexpr Range ranges[] = {direction("nx"), direction("ny"), direction("nz"), millimetres("d")};
  double v[4] = {};
  if (std::string refusal = read(words, ranges, v); !refusal.empty())
    return refused(std::move(refusal));
  const Vec3 normal{v[0], v[1], v[2]};
  if (norm(normal) == 0.0)
    return refused("the normal nx ny nz is zero: expected a direction");
  const Rotation turn = Rotation::from_z_to(normal);
  return {haptic::Plane{}, {turn.rotated({0, 0, v[3] * 1e-3}), turn}, {}};
}

ShapeChoice sphere(Words words) {
  constexpr Range ranges[] = {millimetres("cx"), millimetres("cy"), millimetres("cz"),
                              length("radius")};
  double v[4] = {};
  std::string refusal = read(words, ranges, v);
  return {haptic::Sphere{v[3] * 1e-3}, {metres(v), {}}, std::move(refusal)};
}

ShapeChoice box(Words words) {
  constexpr Range ranges[] = {millimetres("cx"), millimetres("cy"), millimetres("cz"),
                              length("hx"),      length("hy"),      length("hz")};
  constexpr Range rotated[] = {
      {"qw", "", -1e6, 1e6}, {"qx", "", -1e6, 1e6}, {"qy", "", -1e6, 1e6}, {"qz", "", -1e6, 1e6}};
  double v[6] = {}, q[4] = {1, 0, 0, 0};
  std::string refusal = read_numbers(words, ranges, v);
  if (refusal.empty() && words.size() > 6)
    refusal = read(words.subspan(6), rotated, q);
  if (refusal.empty() && q[0] == 0 && q[1] == 0 && q[2] == 0 && q[3] == 0)
    refusal = "the quaternion qw qx qy qz is 0 0 0 0: expected a rotation, such as 1 0 0 0";
  return {haptic::Box{metres(v + 3)},
          {metres(v), Rotation::of(q[0], q[1], q[2], q[3])},
          std::move(refusal)};
}

ShapeChoice disk(Words words) {
  constexpr Range ranges[] = {millimetres("cx"), millimetres("cy"),  millimetres("cz"),
                              direction("nx"),   direction("ny"),    direction("nz"),
                              length("radius"),  length("thickness")};
  double v[8] = {};
  if (std::string refusal = read(words, ranges, v); !refusal.empty())
    return refused(std::move(refusal));
  const Vec3 axis{v[3], v[4], v[5]};
  if (norm(axis) == 0.0)
    return refused("the axis nx ny nz is zero: expected a direction");
  return {haptic::Disk{v[6] * 1e-3, v[7] * 0.5e-3}, {metres(v), Rotation::from_z_to(axis)}, {}};
}

ShapeChoice mesh(Words words, const Host& host) {
  if (words.empty() || !words[0].is_word)
    return refused("expected NAME.obj or NAME.stl, then a scale");
  double scale = 1;
  if (words.size() > 1) {
    constexpr Range ranges[] = {{"scale", "", 1e-6, 1e6}};
    double v[1] = {};
    if (std::string refusal = read(words.subspan(1), ranges, v); !refusal.empty())
      return refused(std::move(refusal));
    scale = v[0];
  }
  const std::string found = host.find_file(words[0].word);
  constexpr std::uint64_t kMaxMeshBytes = std::uint64_t{1} << 30;
  if (found.empty())
    return refused(std::string(words[0].word) +
                   ": file not found beside the patch or in the search path");
  std::string bytes;
  if (const std::string refusal = files::read_file(found, bytes, kMaxMeshBytes); !refusal.empty())
    return refused(std::string(words[0].word) + ": " + refusal);
  files::PolygonMesh read =
      files::read_mesh(bytes, files::MeshFormat::kByContent, {.max_triangles = kMaxTriangles});
  if (!read.error.empty())
    return refused(std::string(words[0].word) + ": " + read.error);
  for (Vec3& corner : read.points) {
    corner = corner * (scale * 1e-3);
    if (!is_finite(corner) || norm(corner) > kMaxCoordinate_mm * 1e-3)
      return refused(std::string(words[0].word) +
                     ": extends beyond 10000 mm: expected a smaller scale");
  }
  auto made = std::make_shared<const haptic::TriangleMesh>(read.points, files::fan_triangles(read));
  if (made->size() == 0)
    return refused(std::string(words[0].word) +
                   ": all its triangles are smaller than 0.001 mm: expected a larger scale");
  return {haptic::MeshSurface{std::move(made)}, {}, {}};
}

} // namespace

ShapeChoice choose_shape(Words words, const Host& host) {
  if (words.empty() || !words[0].is_word)
    return refused("expected plane, sphere, box, disk or mesh");
  const Words rest = words.subspan(1);
  ShapeChoice choice = is(words[0], "plane")    ? plane(rest)
                       : is(words[0], "sphere") ? sphere(rest)
                       : is(words[0], "box")    ? box(rest)
                       : is(words[0], "disk")   ? disk(rest)
                       : is(words[0], "mesh")
                           ? mesh(rest, host)
                           : refused("expected plane, sphere, box, disk or mesh");
  if (!choice.refusal.empty())
    choice.refusal = std::string(words[0].word) + ": " + choice.refusal;
  return choice;
}

} // namespace tactus::phantom
