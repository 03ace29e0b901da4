#pragma once
#include "fem/io/load.hpp"

#include <gmsh.h>

namespace tactus::fem {

/// Reads a CAD file into the current gmsh session. The result is at least one solid, as physical
/// volumes with the solids' names; touching solids have common faces. Faces without a solid are
/// sewn, entities that belong to no solid are removed, and only the chosen ones of separate parts
/// stay (parts.hpp). `unit`: metres per unit of the model.
void import_solids(const std::string& path, const LoadChoice&, double unit,
                   const std::function<void(const std::string&)>& notify);

/// The model's volumes; the length, area or volume of an entity and of several volumes; and boxes,
/// all in the model's unit.
[[nodiscard]] gmsh::vectorpair volumes_of_model();
[[nodiscard]] double mass_of(int dimension, int tag);
[[nodiscard]] double volume_of(const gmsh::vectorpair& volumes);
[[nodiscard]] Box box_of(int dimension, int tag);

} // namespace tactus::fem
