#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// A mesh as bytes for another process on this machine: counts (u64), then nodes (3 doubles each),
/// connectivity (i32), shape, region and intervals of each element (i32), names of regions, node
/// sets.
[[nodiscard]] std::string to_bytes(const Mesh&);

/// The mesh again. Trusts nothing: counts are compared with the bytes there are before anything is
/// allocated, indices with their ranges, coordinates must be finite. Refuses what does not agree.
[[nodiscard]] Mesh mesh_from_bytes(std::string_view);

} // namespace tactus::fem
