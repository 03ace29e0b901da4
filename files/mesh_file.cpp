#include "files/mesh_file.hpp"

#include "files/mesh_formats.hpp"

#include <algorithm>

namespace tactus::files {
namespace {

/// UTF-16 text, its byte order mark included, as ASCII; other letters become question marks.
std::string ascii_of_utf16(std::string_view bytes, bool big_endian) {
  std::string text;
  text.reserve(bytes.size() / 2);
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const char high = bytes[big_endian ? i : i + 1], low = bytes[big_endian ? i + 1 : i];
    text += high == 0 && static_cast<unsigned char>(low) < 128 ? low : '?';
  }
  return text;
}

/// Detects the format of a text from the first line whose keyword belongs to one of the formats.
MeshFormat format_of(std::string_view text) {
  MeshFormat format = MeshFormat::kObj;
  for_each_line(text, [&](std::size_t, std::string_view line) {
    const std::string_view word = Words(line).next();
    const auto is = [word](std::string_view name) { return is_word(word, name); };
    if (is("solid") || is("facet") || is("outer") || is("vertex")) {
      format = MeshFormat::kStl;
      return false;
    }
    return word != "v" && word != "f" && word != "o" && word != "g";
  });
  return format;
}

void read_text(std::string_view text, MeshFormat format, const MeshLimits& limits,
               PolygonMesh& mesh) {
  if (format == MeshFormat::kByContent) {
    if (format_of(text) == MeshFormat::kStl)
      return read_stl_text(text, limits, mesh);
    return read_obj(text, limits, mesh);
  }
  if (format == MeshFormat::kObj)
    return read_obj(text, limits, mesh);
  if (is_stl_text(text))
    return read_stl_text(text, limits, mesh);
  read_binary_stl(text, limits, mesh);
}

} // namespace

std::string line_text(std::size_t line) { return "line " + std::to_string(line) + ": "; }

bool add_point(Words& words, std::size_t line, PolygonMesh& mesh) {
  Vec3 p;
  for (int axis = 0; axis < 3; ++axis) {
    const std::string_view word = words.next();
    const auto value = to_number(word);
    if (!value) {
      mesh.error =
          line_text(line) + (word.find(',') == std::string_view::npos
                                 ? "expected three coordinates"
                                 : std::string(word) + " has a comma: expected a decimal point");
      return false;
    }
    p[axis] = *value;
  }
  if (mesh.points.size() == kMaxMeshPoints) {
    mesh.error = "has more than " + std::to_string(kMaxMeshPoints) + " points";
    return false;
  }
  mesh.points.push_back(p);
  return true;
}

bool accepts(std::size_t triangles, const MeshLimits& limits, PolygonMesh& mesh) {
  if (triangles > limits.max_triangles)
    mesh.error = "has more than " + std::to_string(limits.max_triangles) + " triangles";
  return mesh.error.empty();
}

PolygonMesh read_mesh(std::string_view bytes, MeshFormat format, const MeshLimits& limits) {
  PolygonMesh mesh;
  const bool big_endian = bytes.starts_with("\xFE\xFF");
  if (format != MeshFormat::kObj && is_binary_stl_by_size(bytes))
    read_binary_stl(bytes, limits, mesh);
  else if (big_endian || bytes.starts_with("\xFF\xFE"))
    read_text(ascii_of_utf16(bytes, big_endian), format, limits, mesh);
  else
    read_text(bytes.substr(bytes.starts_with("\xEF\xBB\xBF") ? 3 : 0), format, limits, mesh);
  if (mesh.error.empty() && mesh.polygons() == 0)
    mesh.error = "holds no triangles: expected an STL or OBJ file";
  return mesh;
}

std::vector<std::array<std::uint32_t, 3>> fan_triangles(const PolygonMesh& mesh) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  triangles.reserve(mesh.corner.size() - 2 * mesh.polygons());
  for (std::size_t i = 0; i < mesh.polygons(); ++i) {
    const auto polygon = mesh.polygon(i);
    for (std::size_t k = 2; k < polygon.size(); ++k)
      triangles.push_back({polygon[0], polygon[k - 1], polygon[k]});
  }
  return triangles;
}

} // namespace tactus::files
