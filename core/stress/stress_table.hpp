#pragma once

#include "core/design/shape_parameters.hpp"
#include "core/geometry/vec3.hpp"

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

/// Stress of a part as a function of its shape: values at one shape and their derivatives with
/// respect to the coordinates of control points.
namespace tactus::stress {

/// One scalar of the stress tensor in every element: s = stress + sensitivity dp.
struct StressField {
  std::vector<float> stress;      ///< [N] Pa
  std::vector<float> sensitivity; ///< [P][N] Pa/m
};

/// Both scalars, at the shape for which they were solved.
struct StressBase {
  StressField von_mises;
  StressField max_shear;              ///< empty when the table has none
  std::vector<double> displacement_m; ///< [P] of the parameters; zeros in a table
};

using design::DesignParameter;
using design::kMaxControlPoints;

/// A stress table, written by an offline finite-element program and read by files/tables.hpp;
/// docs/formats/stress_table.md lists the arrays.
struct StressTable {
  StressBase base;
  std::vector<float> weight; ///< [N] m^3, or empty
  std::vector<DesignParameter> parameters;
  std::vector<Vec3> control_point_m;
  double trust_m = 0; ///< largest displacement of a control point for which Taylor's error is small
  std::vector<Vec3> surface_node_m;                          ///< nodes for drawing, or empty
  std::vector<std::array<std::int32_t, 3>> surface_triangle; ///< counterclockwise from outside
  std::vector<std::int32_t> surface_node_element;            ///< [V] element that colours the node
  std::vector<float> surface_weight; ///< [V][C] motion of a node relative to that of a control
                                     ///< point, or empty
  std::string name, material, loads;
  bool has_mesh = false; ///< the table has a mesh of part_stress, which solves it at other shapes

  [[nodiscard]] std::size_t elements() const noexcept { return base.von_mises.stress.size(); }
  [[nodiscard]] bool has_shear() const noexcept { return !base.max_shear.stress.empty(); }
};

inline constexpr std::size_t kMaxElements = 5'000'000;
inline constexpr float kMaxStress_pa = 1e15F;                ///< largest value of both scalars; the
                                                             ///< smallest is 0
inline constexpr std::size_t kMaxSensitivities = 1ULL << 28; // N P; 1 GB per field

/// Reason why a re-solved base does not fit the table (sizes, impossible stresses); else empty.
[[nodiscard]] std::string check_base(const StressTable& table, const StressBase& base);

} // namespace tactus::stress
