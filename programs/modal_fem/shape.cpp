#include "programs/modal_fem/shape.hpp"

#include "fem/design/eigenvalue_sensitivity.hpp"

#include <utility>

namespace tactus::fem {

ShapeDerivatives shape_derivatives(const DesignOptions& options, const Mesh& mesh,
                                   std::span<const Material> materials, const Modes& modes,
                                   std::size_t count, ProgressLine& progress) {
  progress.stage("how the modes follow the shape", 0);
  return shape_derivatives(design_space_of(options, mesh), mesh, materials, modes, count, {});
}

ShapeDerivatives shape_derivatives(const DesignSpace& space, const Mesh& moved,
                                   std::span<const Material> materials, const Modes& modes,
                                   std::size_t count, std::vector<double> displacement) {
  return {space.weights.control_points, space.parameters,
          eigenvalue_sensitivity(moved, materials, {}, {modes.frequency_hz, modes.shapes, count},
                                 space.velocities),
          space.trust, std::move(displacement)};
}

} // namespace tactus::fem
