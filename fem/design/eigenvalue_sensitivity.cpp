#include "fem/design/eigenvalue_sensitivity.hpp"

#include "fem/design/shape_gradient.hpp"
#include "fem/modes/dense.hpp"

#include <numbers>

namespace tactus::fem {

std::vector<double> eigenvalue_sensitivity(const Mesh& mesh, std::span<const Material> materials,
                                           std::span<const SpringPatch> springs,
                                           const GivenModes& modes,
                                           std::span<const DesignVelocity> velocities) {
  const auto& [frequency_hz, shapes, count, same] = modes;
  const std::size_t n = mesh.dofs(), given = frequency_hz.size();
  if (count > given || shapes.size() != n * given)
    throw InputError("derivatives of " + std::to_string(count) +
                     " modes: expected as many frequencies and shapes, got " +
                     std::to_string(given) + " and " + std::to_string(shapes.size() / n));
  const auto laws = elastic_laws(mesh, materials);
  StaticModel springs_alone;
  springs_alone.materials = {materials.begin(), materials.end()};
  springs_alone.springs = {springs.begin(), springs.end()};
  FaceForceDerivative faces(mesh, springs_alone);
  const auto shape = [&](std::size_t k) { return modes.shapes.subspan(k * n, n); };
  std::vector<double> derivative(velocities.size() * count, 0.0);
  for (std::size_t first = 0; first < count;) {
    std::size_t end = first + 1;
    while (end < given && frequency_hz[end] - frequency_hz[end - 1] < same * frequency_hz[end])
      ++end;
    if (end == given)
      throw InputError("mode " + std::to_string(first + 1) +
                       " may belong to a group of equal frequencies beyond the " +
                       std::to_string(given) +
                       " modes given: expected at least one further mode of another frequency");
    const std::size_t size = end - first;
    double lambda = 0;
    for (std::size_t k = first; k < end; ++k) {
      const double omega = 2 * std::numbers::pi * frequency_hz[k];
      lambda += omega * omega / static_cast<double>(size);
    }
    // phi_i' (K' - lambda M') phi_j for every parameter, [parameter][j][i]
    std::vector<double> matrix(velocities.size() * size * size, 0.0);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t j = 0; j <= i; ++j) {
        NodeGradient gradient(mesh.nodes.size());
        add_internal_force_gradient(mesh, laws, shape(first + i), shape(first + j), 1, gradient);
        add_mass_gradient(mesh, laws, shape(first + i), shape(first + j), -lambda, gradient);
        const auto values = by_parameter(gradient, velocities);
        for (std::size_t p = 0; p < velocities.size(); ++p) {
          double value = values[p];
          const auto spring = faces.along(velocities[p], shape(first + i)); // -K_s' phi_i
          for (std::size_t d = 0; d < spring.size(); ++d)
            value -= spring[d] * shape(first + j)[d];
          matrix[(p * size + j) * size + i] = matrix[(p * size + i) * size + j] = value;
        }
      }
    for (std::size_t p = 0; p < velocities.size(); ++p) {
      const auto own =
          symmetric_eigenpairs(std::span(matrix).subspan(p * size * size, size * size), size);
      for (std::size_t i = 0; i < size && first + i < count; ++i)
        derivative[p * count + first + i] = own.values[i];
    }
    first = end;
  }
  return derivative;
}

} // namespace tactus::fem
