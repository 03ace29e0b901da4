#pragma once
#include "core/geometry/vec3.hpp"

#include <array>
#include <string>
#include <vector>

namespace tactus::fem {

/// 6 x 6 elastic matrix in Voigt order xx yy zz yz xz xy with engineering shear strains, Pa.
using ElasticMatrix = std::array<std::array<double, 6>, 6>;

/// A linear elastic solid. It is isotropic if `shear_pa` is zero, else orthotropic, with the
/// indices 1, 2, 3 = longitudinal, radial, tangential in wood:
///   young_pa = E1 E2 E3; shear_pa = G23 G13 G12; poisson = nu23 nu13 nu12 (nu_ij: strain in j for
///   stress along i). Damping: loss factor, or Rayleigh's a (1/s) and b (s).
struct Material {
  std::string name = "aluminium";
  double density = 2700; ///< kg/m^3
  std::array<double, 3> young_pa{70.3e9, 0, 0};
  std::array<double, 3> poisson{0.33, 0, 0};
  std::array<double, 3> shear_pa{0, 0, 0};
  Vec3 axis_1{1, 0, 0}; ///< direction of axis 1 in the body
  Vec3 axis_2{0, 1, 0}; ///< axis 2 lies in the plane of axis_1 and axis_2
  double loss_factor = 1e-4;
  double rayleigh_a = 0, rayleigh_b = 0;
  std::string source;

  [[nodiscard]] bool isotropic() const noexcept { return shear_pa[0] == 0; }
  /// Speed of sound in a thin bar along axis 1, m/s.
  [[nodiscard]] double bar_speed() const noexcept { return std::sqrt(young_pa[0] / density); }
};

/// The elastic matrix in the body's axes. Refuses constants for which deformation would release
/// energy, and names the material; the matrix must be positive definite.
[[nodiscard]] ElasticMatrix elastic_matrix(const Material&);

/// The materials of data/materials.csv, in its order.
[[nodiscard]] const std::vector<Material>& known_materials();

/// A material by name; refuses with the list of names.
[[nodiscard]] Material find_material(const std::string& name);

/// Reads materials from the table's text. Refuses a malformed line and names it.
[[nodiscard]] std::vector<Material> read_materials(const std::string& csv);

} // namespace tactus::fem
