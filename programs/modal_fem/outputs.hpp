#pragma once
#include "fem/mesh/mesh_size.hpp"
#include "programs/modal_fem/options.hpp"

namespace tactus::fem {

/// Refuses, before any work, output files that could not be written.
void check_outputs(const ModalOptions&);

/// Refuses outputs for which the disk has no space; predicts their size from the mesh.
void check_disk_space(const ModalOptions&, const MeshSize&);

} // namespace tactus::fem
