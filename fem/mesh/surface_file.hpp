#pragma once
#include "fem/io/load.hpp"
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// The body of an STL or OBJ file, repaired and filled with tet10: corners are welded, small holes
/// closed, overlapping and touching shells united, nested ones classified as cavities and bodies.
/// With `choice.multi` several separate bodies, each a region under its name in the file. Every
/// repair is reported in one notify() sentence; what cannot be repaired is refused with file,
/// position and remedy.
[[nodiscard]] Mesh mesh_surface_file(const std::string& path, double unit, const LoadChoice&);

/// The same from triangles in memory; refusals name no file.
[[nodiscard]] Mesh mesh_soup(Triangles, const LoadChoice&);

} // namespace tactus::fem
