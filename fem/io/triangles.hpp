#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>

namespace tactus::fem {

/// A closed surface of triangles, outward.
struct Triangles {
  std::vector<Vector3> points;
  std::vector<std::array<int, 3>> triangles;
  std::vector<int> shell; ///< the connected piece of each triangle; shell 0 is the outermost
  int shells = 0;
};

/// Reads STL (ASCII or binary) or OBJ; corners that coincide are one point. Refuses an unreadable
/// file, naming line or byte.
[[nodiscard]] Triangles read_triangles(const std::string& path, double unit);

/// Removes triangles without area or written twice, finds the shells, turns them outward (inner
/// ones inward). Refuses open and non-manifold surfaces and several bodies, naming a triangle and
/// where it lies.
void close(Triangles&);

/// "triangle 17 near (1, 2, 3) mm", counted from one, for refusals.
[[nodiscard]] std::string place_of(const Triangles&, std::size_t triangle);

/// Share of triangles with an angle below `degrees`.
[[nodiscard]] double share_of_slivers(const Triangles&, double degrees);

} // namespace tactus::fem
