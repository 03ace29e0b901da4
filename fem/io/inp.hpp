#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Nodes, volume elements (C3D4, C3D8, C3D10, C3D15, C3D20 and variants), element sets as regions
/// and node sets of a CalculiX / Abaqus file. Refuses a malformed line, naming it.
[[nodiscard]] Mesh read_inp(const std::string& path, double unit);

} // namespace tactus::fem
