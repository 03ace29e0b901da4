#include "fem/material/material.hpp"

#include "fem/io/text.hpp"
#include "fem/material/table.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/small_dense.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// The compliance, 6 x 6, column after column.
std::vector<double> compliance(const Material& m) {
  std::vector<double> s(36, 0.0);
  const auto e =
      m.isotropic() ? std::array{m.young_pa[0], m.young_pa[0], m.young_pa[0]} : m.young_pa;
  const auto nu = m.isotropic() ? std::array{m.poisson[0], m.poisson[0], m.poisson[0]} : m.poisson;
  const double g = m.young_pa[0] / (2 * (1 + m.poisson[0]));
  for (std::size_t i = 0; i < 3; ++i) {
    s[7 * i] = 1 / e[i];
    s[7 * (i + 3)] = 1 / (m.isotropic() ? g : m.shear_pa[i]);
  }
  s[6 * 1 + 2] = s[6 * 2 + 1] = -nu[0] / e[1];
  s[6 * 0 + 2] = s[6 * 2 + 0] = -nu[1] / e[0];
  s[6 * 0 + 1] = s[6 * 1 + 0] = -nu[2] / e[0];
  return s;
}

/// Bond's matrix. It gives the stress in the body's axes from that in the material's axes, which
/// three directions define.
ElasticMatrix bond(const std::array<Vec3, 3>& axis) {
  constexpr std::array<std::array<int, 2>, 6> pair{
      {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  ElasticMatrix t;
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j) {
      const auto [a, b] = pair[i];
      const Vec3 &c = axis[static_cast<std::size_t>(pair[j][0])],
                 &d = axis[static_cast<std::size_t>(pair[j][1])];
      t[i][j] = c == d ? c[a] * c[b] : c[a] * d[b] + d[a] * c[b];
    }
  return t;
}

/// Returns t c t', made exactly symmetric.
ElasticMatrix turned(const std::vector<double>& c, const ElasticMatrix& t) {
  ElasticMatrix half{}, all{};
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k)
        half[i][j] += t[i][k] * c[6 * k + j];
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < 6; ++j)
      for (std::size_t k = 0; k < 6; ++k) {
        all[i][j] += .5 * half[i][k] * t[j][k];
        all[i][j] += .5 * half[j][k] * t[i][k];
      }
  return all;
}

} // namespace

ElasticMatrix elastic_matrix(const Material& m) {
  const auto refuse = [&](const std::string& what) -> void {
    throw InputError("material " + m.name + ": " + what);
  };
  if (!(m.density > 0))
    refuse("density " + std::to_string(m.density) + " kg/m^3: expected above 0");
  if (!(m.young_pa[0] > 0))
    refuse("Young's modulus " + std::to_string(m.young_pa[0]) + " Pa: expected above 0");
  if (m.isotropic() && !(m.poisson[0] > -1 && m.poisson[0] < .5))
    refuse("Poisson's ratio " + std::to_string(m.poisson[0]) + ": expected between -1 and 0.5");
  const std::vector<double> s = compliance(m);
  std::vector<double> c(36, 0.0); // the identity; the inverse of the compliance overwrites it
  for (std::size_t i = 0; i < 6; ++i)
    c[7 * i] = 1;
  if (!std::all_of(s.begin(), s.end(), [](double x) { return std::isfinite(x); }) ||
      !solve_positive_definite(s, c, 6))
    refuse("its elastic constants are unstable, expected a positive definite matrix");
  const Vec3 one = (1 / length(m.axis_1)) * m.axis_1;
  const Vec3 normal = cross(one, m.axis_2);
  if (!(length(normal) > 1e-6 * length(m.axis_2)))
    refuse("its two directions are parallel or zero, expected two different ones");
  const Vec3 three = (1 / length(normal)) * normal, two = cross(three, one);
  return turned(c, bond({one, two, three}));
}

std::vector<Material> read_materials(const std::string& csv) {
  std::vector<Material> materials;
  int number = 0;
  for (const std::string& line : split(csv, '\n')) {
    ++number;
    if (line.empty() || line[0] == '#' || line.starts_with("name,"))
      continue;
    const auto cell = split(line, ',');
    if (cell.size() != 15)
      throw InputError("materials.csv line " + std::to_string(number) + " has " +
                       std::to_string(cell.size()) + " cells, expected 15");
    const auto value = [&](std::size_t i) {
      if (cell[i].empty())
        return 0.0;
      const auto v = to_number(cell[i]);
      if (!v)
        throw InputError("materials.csv line " + std::to_string(number) + ": " + cell[i] +
                         ": not a finite number");
      return *v;
    };
    Material m;
    m.name = cell[0];
    m.density = value(1);
    m.young_pa = {value(2), value(3), value(4)};
    m.shear_pa = {value(5), value(6), value(7)};
    m.poisson = {value(8), value(9), value(10)};
    m.loss_factor = value(11);
    m.rayleigh_a = value(12);
    m.rayleigh_b = value(13);
    m.source = cell[14];
    materials.push_back(m);
  }
  return materials;
}

const std::vector<Material>& known_materials() {
  static const std::vector<Material> materials = read_materials(kMaterialTable);
  return materials;
}

Material find_material(const std::string& name) {
  std::string names;
  for (const Material& m : known_materials()) {
    if (m.name == name)
      return m;
    names += (names.empty() ? "" : ", ") + m.name;
  }
  throw InputError("material " + name + ": expected one of " + names);
}

} // namespace tactus::fem
