#include "programs/modal_fem/outputs.hpp"

#include "programs/body/output_files.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

/// What each output takes. Text: 45 bytes a node, 7 a number of a shape's component or node.
std::vector<Output> outputs(const Order& order, const MeshSize& mesh) {
  const double vertices = mesh.skin_triangles / 2;
  const double modes = std::min(static_cast<double>(order.modes), mesh.dofs());
  const double corners = mesh.nodes_on_planes < 1 ? 10 : 20;
  std::vector<Output> all{
      {"-o", order.output,
       12 * vertices * (modes + 1) + 12 * mesh.skin_triangles +
           (order.residual ? 4 * vertices : 0) +
           (order.design.wanted ? 24 * mesh.nodes + (12 + 4 * corners) * mesh.elements : 0)},
      {"--csv", order.csv, 80 * modes},
      {"--vtu", order.vtu,
       mesh.nodes * (40 + 33 * std::min(modes, 20.0)) + mesh.elements * (10 + 7 * corners)},
      {"--sheet", order.sheet, 1e6},
      {"--export-inp", order.inp, 70 * mesh.nodes + mesh.elements * (10 + 8 * corners)},
      {"--export-petsc", order.petsc, 12 * (18 + 6) * mesh.node_pairs},
  };
  return all;
}

} // namespace

void check_outputs(const Order& order) { check_outputs(outputs(order, {}), order); }

void check_room(const Order& order, const MeshSize& mesh) { check_room(outputs(order, mesh)); }

} // namespace tactus::fem
