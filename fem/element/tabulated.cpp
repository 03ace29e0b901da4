#include "fem/element/tabulated.hpp"

namespace tactus::fem {

Tabulated::Tabulated(Shape shape, std::span<const QuadraturePoint> points) {
  for (const QuadraturePoint& q : points) {
    evaluate(shape, q.at, values.emplace_back());
    weights.push_back(q.weight);
  }
}

namespace {

template <class Points> std::array<Tabulated, 5> all_shapes(Points&& points) {
  return {Tabulated(Shape::tet4, points(Shape::tet4)),
          {Shape::tet10, points(Shape::tet10)},
          {Shape::hex8, points(Shape::hex8)},
          {Shape::hex20, points(Shape::hex20)},
          {Shape::wedge15, points(Shape::wedge15)}};
}

} // namespace

const Tabulated& at_stiffness_points(Shape shape) {
  static const auto tables = all_shapes(stiffness_points);
  return tables[static_cast<std::size_t>(shape)];
}

const Tabulated& at_mass_points(Shape shape) {
  static const auto tables = all_shapes(mass_points);
  return tables[static_cast<std::size_t>(shape)];
}

} // namespace tactus::fem
