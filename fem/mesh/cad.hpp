#pragma once

#include "fem/io/load.hpp"

#include <string>

namespace tactus::fem {

/// Returns "step" or "brep", from the first kilobyte of a CAD file: ISO 10303-21 files begin with
/// `ISO-10303-21;` (blanks and /* comments */ may precede it), OCC's with `DBRep_DrawableShape` or
/// `CASCADE Topology`. Refuses any other content, whatever the file's ending.
[[nodiscard]] std::string cad_format(const std::string& path);

/// Meshes a CAD file in curved tet10. The mesh is graded towards edges at which faces meet at an
/// inner angle above 200 degrees.
[[nodiscard]] Mesh mesh_cad(const std::string& path, const LoadChoice&);

} // namespace tactus::fem
