#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// A mesh as bytes for another process on this machine: counts (u64), then nodes (3 doubles each),
/// connectivity (i32), shape, region and intervals of each element (i32), names of regions, node
/// sets.
[[nodiscard]] std::string to_bytes(const Mesh&);

/// Decodes a mesh. The input is untrusted: counts are compared with the available bytes before any
/// allocation, indices are compared with their ranges, and coordinates must be finite. Refuses
/// inconsistent data.
[[nodiscard]] Mesh mesh_from_bytes(std::string_view);

} // namespace tactus::fem
