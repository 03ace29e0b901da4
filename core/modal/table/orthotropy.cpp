#include "core/modal/table/modal_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace tactus::modal {

bool Orthotropy::possible() const noexcept {
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  const auto& e = youngs_modulus_pa;
  if (!std::all_of(e.begin(), e.end(), positive) ||
      !std::all_of(shear_modulus_pa.begin(), shear_modulus_pa.end(), positive))
    return false;
  // The compliances of the three stresses, scaled to a diagonal of 1, are positive definite.
  const double a = poisson[0] * std::sqrt(e[2] / e[1]), b = poisson[1] * std::sqrt(e[2] / e[0]),
               c = poisson[2] * std::sqrt(e[1] / e[0]);
  return c * c < 1 && 1 - a * a - b * b - c * c - 2 * a * b * c > 0 &&
         norm(cross(axis_1, axis_2)) > 0;
}

double Orthotropy::modulus_along(const Vec3& direction) const noexcept {
  const Vec3 three = cross(axis_1, axis_2), two = cross(three, axis_1);
  std::array<double, 3> square{};
  std::size_t i = 0;
  for (const Vec3& axis : {axis_1, two, three}) {
    const double cosine = dot(direction, axis) / norm(axis);
    square[i++] = cosine * cosine;
  }
  double compliance = 0;
  for (i = 0; i < 3; ++i) {
    const std::size_t j = i == 0 ? 1 : 0, k = i == 2 ? 1 : 2; // the pair 23, 13 or 12
    compliance +=
        square[i] * square[i] / youngs_modulus_pa[i] +
        square[j] * square[k] * (1 / shear_modulus_pa[i] - 2 * poisson[i] / youngs_modulus_pa[j]);
  }
  return 1 / compliance;
}

} // namespace tactus::modal
