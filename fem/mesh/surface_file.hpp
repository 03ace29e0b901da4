#pragma once
#include "fem/io/load.hpp"
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// Repairs the body of an STL or OBJ file and fills it with tet10. Corners are welded, small holes
/// closed, overlapping and touching shells united, and nested shells classified as cavities or
/// bodies. With `choice.multi` the file may have several separate bodies; each is a region with its
/// name in the file. Every repair is reported in one notify() sentence. Refuses a surface that
/// cannot be repaired, with file, position and remedy.
[[nodiscard]] Mesh mesh_surface_file(const std::string& path, double unit, const LoadChoice&);

/// As mesh_surface_file(), from triangles in memory; refusals name no file.
[[nodiscard]] Mesh mesh_soup(Triangles, const LoadChoice&);

} // namespace tactus::fem
