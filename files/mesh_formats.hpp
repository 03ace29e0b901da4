#pragma once

#include "core/text.hpp"
#include "files/mesh_file.hpp"

/// The parts of read_mesh(): one reader per format, and their common functions.
namespace tactus::files {

/// Some programs number points by signed 32-bit integers.
inline constexpr std::size_t kMaxMeshPoints = std::numeric_limits<std::int32_t>::max();

[[nodiscard]] bool is_binary_stl_by_size(std::string_view bytes) noexcept;
[[nodiscard]] bool is_stl_text(std::string_view bytes);
void read_binary_stl(std::string_view bytes, const MeshLimits& limits, PolygonMesh& mesh);
void read_stl_text(std::string_view text, const MeshLimits& limits, PolygonMesh& mesh);
void read_obj(std::string_view text, const MeshLimits& limits, PolygonMesh& mesh);

/// The text "line 7: " for line 7.
[[nodiscard]] std::string line_text(std::size_t line);
/// Appends the next three words as a point; on an error sets `mesh.error` and returns false.
[[nodiscard]] bool add_point(Words& words, std::size_t line, PolygonMesh& mesh);
/// Whether a number of triangles is accepted; if not, sets `mesh.error`.
[[nodiscard]] bool accepts(std::size_t triangles, const MeshLimits& limits, PolygonMesh& mesh);

} // namespace tactus::files
