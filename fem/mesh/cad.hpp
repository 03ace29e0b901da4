#pragma once

#include "fem/io/load.hpp"

#include <string>

namespace tactus::fem {

/// "step" or "brep", from the first kilobyte of a CAD file: ISO 10303-21 files begin with
/// `ISO-10303-21;` (blanks and /* comments */ may precede it), OCC's with `DBRep_DrawableShape` or
/// `CASCADE Topology`. Refuses all other content, whatever the file's ending.
[[nodiscard]] std::string cad_format(const std::string& path);

/// A CAD file in curved tet10. Edges where faces meet at an inner angle above 200 degrees are found
/// and the mesh is graded into them.
[[nodiscard]] Mesh mesh_cad(const std::string& path, const LoadChoice&);

} // namespace tactus::fem
