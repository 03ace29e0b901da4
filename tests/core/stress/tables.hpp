#pragma once

#include "core/stress/stress_table.hpp"

#include <cmath>
#include <memory>
#include <string>
#include <vector>

/// Parts in closed form.
namespace tactus::test {

/// The four elements of the specification's example: three parameters of one control point.
inline stress::StressTable four_elements() {
  stress::StressTable table;
  table.base.von_mises = {{10, 20, 30, 40}, {1, 0, 0, 1, 0, 1, 0, 1, 0, 0, 1, 1}};
  table.base.displacement_m = {0, 0, 0};
  table.parameters = {{0, 0, -1, 1}, {0, 1, -1, 1}, {0, 2, -1, 1}};
  table.control_point_m = {{}};
  table.trust_m = 0.01;
  return table;
}

inline std::shared_ptr<const stress::StressTable> shared(stress::StressTable table) {
  return std::make_shared<const stress::StressTable>(std::move(table));
}

/// A cantilever under a force at its tip in bending, of outer fibre stress s = 6 F (L - x)/(b h^2)
/// with F, b and the heights h in m chosen so that s = (1 - x/L) 1e6 (0.02/h)^2 Pa. Two control
/// points raise h by (1 - x/L) d0 + x/L d1; the derivatives are exact.
class Cantilever {
public:
  static constexpr std::size_t kElements = 50;
  static double height_m(std::size_t i, double d0, double d1) {
    const double x = (static_cast<double>(i) + 0.5) / kElements;
    return 0.02 + (1 - x) * d0 + x * d1;
  }
  static double stress_pa(std::size_t i, double d0, double d1) {
    const double x = (static_cast<double>(i) + 0.5) / kElements;
    return (1 - x) * 1e6 * std::pow(0.02 / height_m(i, d0, d1), 2);
  }
  static double mean_pa(double d0, double d1) {
    double sum = 0;
    for (std::size_t i = 0; i < kElements; ++i)
      sum += stress_pa(i, d0, d1);
    return sum / kElements;
  }
  static stress::StressBase solve(double d0, double d1) {
    stress::StressBase base;
    base.displacement_m = {d0, d1};
    auto& field = base.von_mises;
    field.sensitivity.resize(2 * kElements);
    for (std::size_t i = 0; i < kElements; ++i) {
      const double x = (static_cast<double>(i) + 0.5) / kElements;
      const double s = stress_pa(i, d0, d1), slope = -2 * s / height_m(i, d0, d1);
      field.stress.push_back(static_cast<float>(s));
      field.sensitivity[i] = static_cast<float>(slope * (1 - x));
      field.sensitivity[kElements + i] = static_cast<float>(slope * x);
    }
    return base;
  }
  static stress::StressTable table() {
    stress::StressTable table;
    table.base = solve(0, 0);
    table.parameters = {{0, 1, -0.01, 0.02}, {1, 1, -0.01, 0.02}};
    table.control_point_m = {{0, 0.01, 0}, {0.1, 0.01, 0}};
    table.trust_m = 0.002;
    // Its side in two triangles; the upper corners are the control points.
    table.surface_node_m = {{0, -0.01, 0}, {0.1, -0.01, 0}, {0.1, 0.01, 0}, {0, 0.01, 0}};
    table.surface_triangle = {{0, 1, 2}, {0, 2, 3}};
    table.surface_node_element = {0, kElements - 1, kElements - 1, 0};
    table.surface_weight = {0, 0, 0, 0, 0, 1, 1, 0};
    return table;
  }
};

} // namespace tactus::test
