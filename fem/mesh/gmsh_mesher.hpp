#pragma once
#include "fem/io/load.hpp"
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// gmsh meshes; everything it knows is taken over and forgotten. Not for several threads.

/// A CAD file in curved tet10. Edges where faces meet at an inner angle above 200 degrees are found
/// and the mesh is graded into them.
[[nodiscard]] Mesh mesh_cad(const std::string& path, const LoadChoice&);

/// A closed triangle surface filled with tet10. Good triangles are kept; poor or needlessly fine
/// ones are renewed.
[[nodiscard]] Mesh mesh_surface(const Triangles&, const LoadChoice&);

} // namespace tactus::fem
