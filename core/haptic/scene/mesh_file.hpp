#pragma once

#include "core/haptic/scene/triangle_mesh.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::haptic {

/// Corners in the file's own unit.
struct ParsedMesh {
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  std::string error; ///< one sentence that names the line or the byte; empty when all is well
};

/// Triangles from the bytes of an STL file, binary or text, or of a Wavefront OBJ file, told apart
/// by what they hold. OBJ: `v` and `f`, polygons cut into fans, indices from the end too; all else
/// is passed over.
[[nodiscard]] ParsedMesh parse_mesh(std::string_view bytes);

} // namespace tactus::haptic
