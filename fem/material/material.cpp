#include "fem/material/material.hpp"

#include "fem/io/text.hpp"
#include "fem/material/table.hpp"
#include "fem/mesh/mesh.hpp"

#include <Eigen/Dense>

namespace tactus::fem {
namespace {

using Matrix6 = Eigen::Matrix<double, 6, 6>;

Matrix6 compliance(const Material& m) {
  Matrix6 s = Matrix6::Zero();
  const auto e =
      m.isotropic() ? std::array{m.young_pa[0], m.young_pa[0], m.young_pa[0]} : m.young_pa;
  const auto nu = m.isotropic() ? std::array{m.poisson[0], m.poisson[0], m.poisson[0]} : m.poisson;
  const double g = m.young_pa[0] / (2 * (1 + m.poisson[0]));
  for (int i = 0; i < 3; ++i) {
    s(i, i) = 1 / e[static_cast<std::size_t>(i)];
    s(i + 3, i + 3) = 1 / (m.isotropic() ? g : m.shear_pa[static_cast<std::size_t>(i)]);
  }
  s(1, 2) = s(2, 1) = -nu[0] / e[1];
  s(0, 2) = s(2, 0) = -nu[1] / e[0];
  s(0, 1) = s(1, 0) = -nu[2] / e[0];
  return s;
}

/// Bond's matrix: stress in the body's axes from stress in the material's, whose directions are the
/// columns of `r`.
Matrix6 bond(const Eigen::Matrix3d& r) {
  constexpr std::array<std::array<int, 2>, 6> pair{
      {{0, 0}, {1, 1}, {2, 2}, {1, 2}, {0, 2}, {0, 1}}};
  Matrix6 t;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) {
      const auto [a, b] = pair[static_cast<std::size_t>(i)];
      const auto [c, d] = pair[static_cast<std::size_t>(j)];
      t(i, j) = c == d ? r(a, c) * r(b, c) : r(a, c) * r(b, d) + r(a, d) * r(b, c);
    }
  return t;
}

} // namespace

ElasticMatrix elastic_matrix(const Material& m) {
  const auto refuse = [&](const std::string& what) -> void {
    throw InputError("material " + m.name + ": " + what);
  };
  if (!(m.density > 0))
    refuse("density is " + std::to_string(m.density) + " kg/m^3, expected above 0");
  if (!(m.young_pa[0] > 0))
    refuse("Young's modulus is " + std::to_string(m.young_pa[0]) + " Pa, expected above 0");
  if (m.isotropic() && !(m.poisson[0] > -1 && m.poisson[0] < .5))
    refuse("Poisson's ratio is " + std::to_string(m.poisson[0]) + ", expected within -1 and 0.5");
  const Matrix6 s = compliance(m);
  const Eigen::LLT<Matrix6> factor(s);
  if (!s.allFinite() || factor.info() != Eigen::Success)
    refuse("its elastic constants would release energy, expected a positive definite matrix");
  Matrix6 c = factor.solve(Matrix6::Identity());
  const Vector3 one = (1 / length(m.axis_1)) * m.axis_1;
  const Vector3 normal = cross(one, m.axis_2);
  if (!(length(normal) > 1e-6 * length(m.axis_2)))
    refuse("its two directions are parallel or zero, expected two different ones");
  const Vector3 three = (1 / length(normal)) * normal, two = cross(three, one);
  Eigen::Matrix3d r;
  for (int k = 0; k < 3; ++k)
    r.row(k) << one[k], two[k], three[k];
  const Matrix6 t = bond(r);
  c = (t * c * t.transpose()).eval();
  ElasticMatrix matrix;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      matrix[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = .5 * (c(i, j) + c(j, i));
  return matrix;
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
                         " is no number");
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
  throw InputError("material " + name + " is not known: expected one of " + names);
}

} // namespace tactus::fem
