#pragma once

#include "core/design/shape_parameters.hpp"
#include "files/table_arrays.hpp"

namespace tactus::files {

/// Reads `control_points` f8 [C,3] m, `parameters` f8 [P,4] (control point, axis, lowest and
/// highest displacement in m) and `trust` f8 [] m, all required. What is wrong is refused in
/// `arrays`.
void read_shape_parameters(TableArrays& arrays, const NpzFile& file,
                           design::ShapeParameters& shape);

} // namespace tactus::files
