#include "fem/modes/body.hpp"

#include "fem/element/jacobian.hpp"
#include "fem/element/quadrature.hpp"

#include <numbers>

namespace tactus::fem {

MassProperties mass_properties(const Mesh& mesh, std::span<const Material> materials) {
  MassProperties body;
  ShapeValues values;
  Vec3 first;
  std::array<std::array<double, 3>, 3> second{};
  const Vec3 middle = bounding_box(mesh.nodes).low;
  for (const Element& e : mesh.elements)
    for (const QuadraturePoint& q : mass_points(e.shape)) {
      evaluate(e.shape, q.at, values);
      const double m = materials[static_cast<std::size_t>(e.region)].density * q.weight *
                       jacobian(mesh, e, values).determinant;
      Vec3 x;
      const auto nodes = mesh.nodes_of(e);
      for (std::size_t a = 0; a < nodes.size(); ++a)
        x += values.value[a] * (mesh.nodes[static_cast<std::size_t>(nodes[a])] - middle);
      body.mass += m;
      first += m * x;
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          second[i][j] += m * x[static_cast<int>(i)] * x[static_cast<int>(j)];
    }
  const Vec3 c = (1 / body.mass) * first;
  body.centre = middle + c;
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      second[i][j] -= body.mass * c[static_cast<int>(i)] * c[static_cast<int>(j)];
  const double trace = second[0][0] + second[1][1] + second[2][2];
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      body.inertia[3 * i + j] = (i == j ? trace : 0) - second[i][j];
  return body;
}

namespace {

/// u' K u of every mode.
std::vector<double> energies(const Matrices& m, const Modes& modes) {
  const std::size_t n = m.dofs(), count = modes.frequency_hz.size();
  std::vector<double> image(n * count), energy(count, 0.0);
  m.multiply_stiffness(modes.shapes, image, count);
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < n; ++i)
      energy[k] += modes.shapes[k * n + i] * image[k * n + i];
  return energy;
}

double angular(double frequency) { return 2 * std::numbers::pi * frequency; }

} // namespace

std::vector<double> poisson_slopes(const Mesh& mesh, std::span<const Material> materials,
                                   const Matrices& matrices, const Modes& modes) {
  if (materials.size() != 1 || !materials[0].isotropic())
    return {};
  // Lamé's constants are smooth in nu, so the error of their central differences is of the order of
  // the squared step.
  constexpr double kStep = 1e-4;
  std::vector<double> slopes(modes.frequency_hz.size(), 0.0);
  Matrices work = matrices;
  for (const double sign : {-1.0, 1.0}) {
    Material m = materials[0];
    m.poisson[0] += sign * kStep;
    if (!(m.poisson[0] < .5))
      return {};
    assemble_stiffness(mesh, std::span(&m, 1), -1, work);
    const auto energy = energies(work, modes);
    for (std::size_t k = 0; k < slopes.size(); ++k) {
      const double lambda = angular(modes.frequency_hz[k]) * angular(modes.frequency_hz[k]);
      slopes[k] += sign * energy[k] / (2 * kStep) / (2 * lambda);
    }
  }
  return slopes;
}

std::vector<double> loss_factors(const Mesh& mesh, std::span<const Material> materials,
                                 const Matrices& matrices, const Modes& modes) {
  std::vector<double> loss(modes.frequency_hz.size(), 0.0);
  Matrices work = matrices;
  for (std::size_t region = 0; region < materials.size(); ++region) {
    std::vector<double> share(loss.size(), 1.0);
    if (materials.size() > 1) {
      assemble_stiffness(mesh, materials, static_cast<int>(region), work);
      share = energies(work, modes);
    }
    const Material& m = materials[region];
    for (std::size_t k = 0; k < loss.size(); ++k) {
      const double omega = angular(modes.frequency_hz[k]);
      if (materials.size() > 1)
        share[k] /= omega * omega;
      loss[k] += share[k] *
                 (m.loss_factor > 0 ? m.loss_factor : m.rayleigh_a / omega + m.rayleigh_b * omega);
    }
  }
  return loss;
}

} // namespace tactus::fem
