#pragma once
#include "fem/mesh/mesh.hpp"

#include <functional>

namespace tactus::fem {

/// The type of a shape's elements in CalculiX' and Abaqus' files, such as "C3D10".
[[nodiscard]] std::string_view inp_type(Shape) noexcept;

/// Reads nodes, volume elements (C3D4, C3D5, C3D6, C3D8, C3D10, C3D15, C3D20 and variants), sets,
/// and materials with their sections from a CalculiX / Abaqus file. A region is the intersection of
/// one ELSET and one section. `unit`: metres per unit of length; constants are in the corresponding
/// unit system (InpMaterials). Keywords of the analysis, such as *BOUNDARY and *STEP, are skipped
/// and reported by `notify`. Any other keyword, parameter or element type is refused with its line.
[[nodiscard]] Mesh read_inp(const std::string& path, double unit,
                            const std::function<void(const std::string&)>& notify = {});

} // namespace tactus::fem
