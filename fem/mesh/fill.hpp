#pragma once
#include "fem/io/load.hpp"
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Fills a closed triangle surface with tet10. Good triangles are kept; poor or needlessly fine
/// surfaces are remeshed first.
[[nodiscard]] Mesh mesh_surface(const Triangles&, const LoadChoice&);

} // namespace tactus::fem
