#pragma once

#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

/// Surfaces as STL files, binary or text, and as Wavefront OBJ files.
namespace tactus::files {

/// The polygons of a file as the file lists them.
struct PolygonMesh {
  std::vector<Vec3> points;          ///< in the file's own unit
  std::vector<std::uint32_t> corner; ///< indices into `points`, polygon after polygon
  std::vector<std::uint32_t> end;    ///< end of each polygon in `corner`; empty if all are
                                     ///< triangles
  std::vector<std::uint32_t> group;  ///< each polygon's index into `groups`; empty if all have
                                     ///< index 0
  std::vector<std::string> groups;   ///< names of solids or objects; may be empty
  /// Names the line and the word of the first free-form curve or surface of an OBJ file, which is
  /// ignored; empty when there is none.
  std::string free_form;
  /// Error text to append to the file's name; it names the line or the triangle. Empty if there is
  /// no error.
  std::string error;

  [[nodiscard]] std::size_t polygons() const noexcept {
    return end.empty() ? corner.size() / 3 : end.size();
  }
  [[nodiscard]] std::span<const std::uint32_t> polygon(std::size_t i) const noexcept {
    if (end.empty())
      return std::span(corner).subspan(3 * i, 3);
    const std::size_t begin = i == 0 ? 0 : end[i - 1];
    return std::span(corner).subspan(begin, end[i] - begin);
  }
  [[nodiscard]] std::size_t group_of(std::size_t polygon) const noexcept {
    return group.empty() ? 0 : group[polygon];
  }
};

enum class MeshFormat { kByContent, kStl, kObj };

/// Limits that a reader enforces.
struct MeshLimits {
  std::size_t max_triangles = std::numeric_limits<std::int32_t>::max() / 3;
  std::size_t max_face_corners = std::numeric_limits<std::int32_t>::max();
};

/// Reads polygons from the bytes of a file. An STL file is text if it begins with "solid", names a
/// facet, and its length does not match a binary triangle count. Binary files may begin with
/// "solid" too. Of an OBJ file it reads `v` and `f`, with indices from the beginning or the end.
/// `o` begins a group, or `g` in a file without `o`. OBJ lines and points are ignored. Words that
/// belong to neither format are refused. Text may be UTF-8 or UTF-16 with a byte order mark.
[[nodiscard]] PolygonMesh read_mesh(std::string_view bytes,
                                    MeshFormat format = MeshFormat::kByContent,
                                    const MeshLimits& limits = {});

/// Each polygon as triangles about its first corner.
[[nodiscard]] std::vector<std::array<std::uint32_t, 3>> fan_triangles(const PolygonMesh& mesh);

} // namespace tactus::files
