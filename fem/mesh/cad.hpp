#pragma once
#include "fem/io/load.hpp"

namespace tactus::fem {

/// A CAD file in curved tet10. Edges where faces meet at an inner angle above 200 degrees are found
/// and the mesh is graded into them.
[[nodiscard]] Mesh mesh_cad(const std::string& path, const LoadChoice&);

} // namespace tactus::fem
