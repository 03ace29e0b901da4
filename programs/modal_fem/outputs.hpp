#pragma once
#include "fem/mesh/mesh_size.hpp"
#include "programs/modal_fem/order.hpp"

namespace tactus::fem {

/// Refuses, before any work, output files that could not be written: a missing or closed folder, a
/// folder or device in the file's place, one name for two files, the body's own file. Touches no
/// existing file.
void check_outputs(const Order&);

/// The same for one file.
void check_output(const std::string& option, const std::string& path);

/// Refuses outputs that the disk has no room for, foretold from the mesh.
void check_room(const Order&, const MeshSize&);

} // namespace tactus::fem
