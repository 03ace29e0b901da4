#include "programs/modal_fem/shape.hpp"

#include "fem/design/eigenvalue_sensitivity.hpp"

namespace tactus::fem {

ShapeDerivatives shape_derivatives(const DesignOrder& order, const Mesh& mesh,
                                   std::span<const Material> materials, const Modes& modes,
                                   std::size_t count, ProgressLine& progress) {
  progress.stage("how the modes follow the shape", 0);
  const DesignSpace space = design_space_of(order, mesh);
  return {space.weights.control_points, space.parameters,
          eigenvalue_sensitivity(mesh, materials, {}, modes.frequency_hz, modes.shapes, count,
                                 space.velocities),
          space.trust};
}

} // namespace tactus::fem
