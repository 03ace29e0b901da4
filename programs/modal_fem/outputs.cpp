#include "programs/modal_fem/outputs.hpp"

#include "programs/body/output_files.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// The sizes of the outputs. A text file has 45 bytes per node, and 7 bytes per number of a mode
/// shape's component or of a node.
std::vector<Output> outputs(const ModalOptions& options, const MeshSize& mesh) {
  const double vertices = mesh.skin_triangles / 2;
  const double modes = std::min(static_cast<double>(options.modes), mesh.dofs());
  const double corners = mesh.nodes_on_planes < 1 ? 10 : 20;
  std::vector<Output> all{
      {"-o", options.output,
       12 * vertices * (modes + 1) + 12 * mesh.skin_triangles +
           (options.residual ? 4 * vertices : 0) +
           (options.design.requested ? 24 * mesh.nodes + (12 + 4 * corners) * mesh.elements : 0)},
      {"--csv", options.csv, 80 * modes},
      {"--vtu", options.vtu,
       mesh.nodes * (40 + 33 * std::min(modes, 20.0)) + mesh.elements * (10 + 7 * corners)},
      {"--sheet", options.sheet, 1e6},
      {"--export-inp", options.inp, 70 * mesh.nodes + mesh.elements * (10 + 8 * corners)},
      {"--export-petsc", options.petsc, 12 * (18 + 6) * mesh.node_pairs},
  };
  return all;
}

} // namespace

void check_outputs(const ModalOptions& options) { check_outputs(outputs(options, {}), options); }

void check_disk_space(const ModalOptions& options, const MeshSize& mesh) {
  check_disk_space(outputs(options, mesh));
}

} // namespace tactus::fem
