#pragma once
#include "fem/io/load.hpp"

#include <gmsh.h>

namespace tactus::fem {

/// Reads a CAD file into gmsh's present session: at least one solid, touching ones with common
/// faces and as physical volumes under their names. Faces without a solid are sewn, what belongs to
/// no solid is left out, and of separate parts those of the choice stay (parts.hpp). `unit`: metres
/// of the model's lengths.
void import_solids(const std::string& path, const LoadChoice&, double unit,
                   const std::function<void(const std::string&)>& notify);

/// The model's volumes; length, area or volume of an entity and of several volumes, and boxes, in
/// the model's unit.
[[nodiscard]] gmsh::vectorpair volumes_of_model();
[[nodiscard]] double mass_of(int dimension, int tag);
[[nodiscard]] double volume_of(const gmsh::vectorpair& volumes);
[[nodiscard]] Box box_of(int dimension, int tag);

} // namespace tactus::fem
