#pragma once
#include <string>

namespace tactus::fem {

/// "step" or "brep", from the first kilobyte of a CAD file: ISO 10303-21 files begin with
/// `ISO-10303-21;` (blanks and /* comments */ may come before), OCC's with `DBRep_DrawableShape` or
/// `CASCADE Topology`. Refuses everything else, under any ending.
[[nodiscard]] std::string cad_format(const std::string& path);

} // namespace tactus::fem
