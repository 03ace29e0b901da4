#pragma once
#include "fem/element/jacobian.hpp"
#include "fem/element/quadrature.hpp"

#include <vector>

namespace tactus::fem {

/// Shape functions at quadrature points: the same for every element of a shape.
struct Tabulated {
  std::vector<ShapeValues> values;
  std::vector<double> weights;

  Tabulated(Shape, std::span<const QuadraturePoint>);
};

[[nodiscard]] const Tabulated& at_stiffness_points(Shape);
[[nodiscard]] const Tabulated& at_mass_points(Shape);

/// Volume of an element, m^3; below 0 if it is inverted.
[[nodiscard]] inline double volume_of(const Mesh& mesh, const Element& e) {
  const Tabulated& table = at_mass_points(e.shape);
  double sum = 0;
  for (std::size_t q = 0; q < table.weights.size(); ++q)
    sum += table.weights[q] * jacobian(mesh, e, table.values[q]).determinant;
  return sum;
}

/// Gradients in space of an element's shape functions at a point.
struct PointGradients {
  std::array<Vec3, kMaxNodes> slope; ///< grad N_a, 1/m
  double determinant = 0;            ///< dV relative to the reference volume, m^3
};
inline void gradients(const Mesh& mesh, const Element& e, const ShapeValues& values,
                      PointGradients& out) noexcept {
  const Jacobian j = jacobian(mesh, e, values);
  const auto n = static_cast<std::size_t>(node_count(e.shape));
  for (std::size_t a = 0; a < n; ++a)
    out.slope[a] = j.to_space(values.derivative[a]);
  out.determinant = j.determinant;
}

} // namespace tactus::fem
