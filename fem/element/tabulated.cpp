#include "fem/element/tabulated.hpp"

namespace tactus::fem {

Tabulated::Tabulated(Shape shape, std::span<const QuadraturePoint> points) {
  for (const QuadraturePoint& q : points) {
    evaluate(shape, q.at, values.emplace_back());
    weights.push_back(q.weight);
  }
}

const Tabulated& at_stiffness_points(Shape shape) {
  static const auto tables = for_shapes([](Shape s) { return Tabulated(s, stiffness_points(s)); });
  return tables[static_cast<std::size_t>(shape)];
}

const Tabulated& at_mass_points(Shape shape) {
  static const auto tables = for_shapes([](Shape s) { return Tabulated(s, mass_points(s)); });
  return tables[static_cast<std::size_t>(shape)];
}

} // namespace tactus::fem
