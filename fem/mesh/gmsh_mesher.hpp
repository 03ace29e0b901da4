#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// gmsh meshes; everything it knows is taken over and forgotten. Not for several threads.

} // namespace tactus::fem
