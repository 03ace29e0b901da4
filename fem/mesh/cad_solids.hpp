#pragma once
#include "fem/io/load.hpp"

#include <gmsh.h>

namespace tactus::fem {

/// Reads a CAD file into the current gmsh session: at least one solid, touching solids with common
/// faces, as physical volumes under their names. Faces without a solid are sewn; entities that
/// belong to no solid are removed; of separate parts only those chosen stay (parts.hpp). `unit`:
/// metres per unit of the model.
void import_solids(const std::string& path, const LoadChoice&, double unit,
                   const std::function<void(const std::string&)>& notify);

/// The model's volumes; length, area or volume of an entity and of several volumes, and boxes, in
/// the model's unit.
[[nodiscard]] gmsh::vectorpair volumes_of_model();
[[nodiscard]] double mass_of(int dimension, int tag);
[[nodiscard]] double volume_of(const gmsh::vectorpair& volumes);
[[nodiscard]] Box box_of(int dimension, int tag);

} // namespace tactus::fem
