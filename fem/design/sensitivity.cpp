#include "fem/design/sensitivity.hpp"

#include "fem/design/shape_gradient.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// Number of parameters whose integrals are computed in one pass over the elements, since they
/// share the geometry.
constexpr std::size_t kBlockParameters = 8;

/// The design velocities V = dX/dp of up to eight parameters at every node.
struct VelocityBlock {
  std::size_t count = 0;
  std::vector<std::array<Vec3, kBlockParameters>> of_node;
  std::vector<std::uint8_t> moves; ///< [node], one bit per parameter

  VelocityBlock(std::size_t nodes, std::span<const DesignVelocity> velocities)
      : count(velocities.size()), of_node(nodes), moves(nodes, 0) {
    for (std::size_t k = 0; k < count; ++k)
      for (std::size_t i = 0; i < velocities[k].node.size(); ++i) {
        const auto n = static_cast<std::size_t>(velocities[k].node[i]);
        of_node[n][k] = velocities[k].velocity[i];
        moves[n] = static_cast<std::uint8_t>(moves[n] | 1U << k);
      }
  }
  [[nodiscard]] unsigned moving(std::span<const int> nodes) const noexcept {
    unsigned any = 0;
    for (const int n : nodes)
      any |= moves[static_cast<std::size_t>(n)];
    return any;
  }
  /// L, the gradient of V, of parameter k at a point.
  [[nodiscard]] Tensor gradient(const PointGradients& at, std::span<const int> nodes,
                                std::size_t k) const noexcept {
    Tensor l{};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const Vec3& v = of_node[static_cast<std::size_t>(nodes[a])][k];
      for (std::size_t i = 0; i < 3; ++i) {
        const double value = v[static_cast<int>(i)];
        l[i][0] += value * at.slope[a].x;
        l[i][1] += value * at.slope[a].y;
        l[i][2] += value * at.slope[a].z;
      }
    }
    return l;
  }
};

Tensor negative(const Tensor& a) {
  Tensor b = a;
  for (auto& row : b)
    for (double& x : row)
      x = -x;
  return b;
}

/// right -= K' u for each parameter of the block, N per unit of the parameter.
void subtract_internal_forces(const Mesh& mesh, std::span<const ElasticLaw> laws,
                              std::span<const double> u, const VelocityBlock& block,
                              std::span<double> right) {
  const std::size_t n = mesh.dofs();
  PointGradients at;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    const unsigned moving = block.moving(nodes);
    if (!moving)
      continue;
    const ElasticLaw& law = laws[static_cast<std::size_t>(e.region)];
    const ElementField own = gather(u, nodes);
    const Tabulated& table = at_stiffness_points(e.shape);
    for (std::size_t q = 0; q < table.weights.size(); ++q) {
      gradients(mesh, e, table.values[q], at);
      const double weight = table.weights[q] * at.determinant;
      const Tensor h = field_gradient(at, own, nodes.size());
      const Tensor sigma = to_tensor(stress_of(law, h));
      for (std::size_t k = 0; k < block.count; ++k) {
        if (!(moving >> k & 1U))
          continue;
        const Tensor l = block.gradient(at, nodes, k);
        const Tensor change = to_tensor(stress_of(law, negative(h * l)));
        const double growth = trace(l);
        Tensor t; // sigma' + sigma tr L - sigma L'
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 3; ++j)
            t[i][j] = change[i][j] + growth * sigma[i][j] -
                      (sigma[i][0] * l[j][0] + sigma[i][1] * l[j][1] + sigma[i][2] * l[j][2]);
        double* to = &right[k * n];
        for (std::size_t a = 0; a < nodes.size(); ++a) {
          const Vec3& g = at.slope[a];
          for (std::size_t i = 0; i < 3; ++i)
            to[3 * static_cast<std::size_t>(nodes[a]) + i] -=
                weight * (t[i][0] * g.x + t[i][1] * g.y + t[i][2] * g.z);
        }
      }
    }
  }
}

/// right += f' of gravity for each parameter of the block.
void add_gravity(const Mesh& mesh, std::span<const ElasticLaw> laws, std::span<const Load> loads,
                 const VelocityBlock& block, std::span<double> right) {
  const std::size_t n = mesh.dofs();
  PointGradients at;
  for (const Load& load : loads) {
    const auto* gravity = std::get_if<Gravity>(&load);
    if (!gravity)
      continue;
    for (const Element& e : mesh.elements) {
      const auto nodes = mesh.nodes_of(e);
      if (!block.moving(nodes))
        continue;
      const Tabulated& table = at_mass_points(e.shape);
      for (std::size_t q = 0; q < table.weights.size(); ++q) {
        gradients(mesh, e, table.values[q], at);
        const double mass =
            laws[static_cast<std::size_t>(e.region)].density * table.weights[q] * at.determinant;
        for (std::size_t k = 0; k < block.count; ++k) {
          const double growth = trace(block.gradient(at, nodes, k));
          for (std::size_t a = 0; a < nodes.size(); ++a)
            for (std::size_t i = 0; i < 3; ++i)
              right[k * n + 3 * static_cast<std::size_t>(nodes[a]) + i] +=
                  mass * growth * table.values[q].value[a] *
                  gravity->acceleration[static_cast<int>(i)];
        }
      }
    }
  }
}

/// A solved problem whose displacement is differentiated.
struct SolvedProblem {
  SolvedProblem(const Mesh& m, const StaticModel& s, StaticAnalysis& a)
      : mesh(m), model(s), analysis(a), laws(elastic_laws(m, s.materials)), faces(m, s) {}

  const Mesh& mesh;
  const StaticModel& model;
  StaticAnalysis& analysis;
  std::vector<ElasticLaw> laws;
  FaceForceDerivative faces;
};

/// du/dp of a block of parameters, column by column.
std::vector<double> block_sensitivity(SolvedProblem& problem,
                                      std::span<const DesignVelocity> velocities,
                                      const VelocityBlock& block) {
  auto& [mesh, model, analysis, laws, faces] = problem;
  const std::size_t n = mesh.dofs();
  const auto& u = analysis.solution.displacement;
  std::vector<double> right(n * block.count, 0.0);
  subtract_internal_forces(mesh, laws, u, block, right);
  add_gravity(mesh, laws, model.loads, block, right);
  for (std::size_t k = 0; k < block.count; ++k) {
    const auto face = faces.along(velocities[k], u);
    for (std::size_t i = 0; i < face.size(); ++i)
      right[k * n + i] += face[i];
    for (std::size_t i = 0; i < n; ++i)
      if (analysis.system.matrices.constrained[i])
        right[k * n + i] = 0;
  }
  analysis.factor->solve(right, right, block.count);
  return right;
}

template <class Work>
void for_each_block(const Mesh& mesh, std::span<const DesignVelocity> velocities, Work&& work) {
  for (std::size_t first = 0; first < velocities.size(); first += kBlockParameters) {
    const auto own =
        velocities.subspan(first, std::min(kBlockParameters, velocities.size() - first));
    work(first, own, VelocityBlock(mesh.nodes.size(), own));
  }
}

double product(const Stress& slope, const Stress& change) {
  double sum = 0;
  for (std::size_t v = 0; v < 6; ++v)
    sum += slope[v] * change[v];
  return sum;
}

/// d scalar / d (each element's measure) and d scalar / d (each element's volume).
struct ScalarSlopes {
  double value = 0;
  std::vector<double> by_measure, by_volume;
};

ScalarSlopes slopes_of(const StressScalar& scalar, std::span<const double> s,
                       std::span<const double> volumes) {
  const std::size_t n = s.size();
  ScalarSlopes slopes{0, std::vector<double>(n, 0.0), std::vector<double>(n, 0.0)};
  double whole = 0, largest = 0;
  for (std::size_t e = 0; e < n; ++e) {
    whole += volumes[e];
    largest = std::max(largest, s[e]);
  }
  if (scalar.kind == StressScalar::Kind::mean) {
    for (std::size_t e = 0; e < n; ++e) {
      slopes.value += s[e] / static_cast<double>(n);
      slopes.by_measure[e] = 1 / static_cast<double>(n);
    }
    return slopes;
  }
  if (scalar.kind == StressScalar::Kind::volume_mean) {
    for (std::size_t e = 0; e < n; ++e)
      slopes.value += volumes[e] / whole * s[e];
    for (std::size_t e = 0; e < n; ++e) {
      slopes.by_measure[e] = volumes[e] / whole;
      slopes.by_volume[e] = (s[e] - slopes.value) / whole;
    }
    return slopes;
  }
  const double p = scalar.power;
  if (!(p >= 1) || !std::isfinite(p))
    throw InputError("a p-norm of the stress has the power " + std::to_string(p) +
                     ", expected 1 or more");
  if (largest == 0)
    return slopes;
  double sum = 0; // scaled by the largest, since powers could overflow
  for (std::size_t e = 0; e < n; ++e)
    sum += volumes[e] / whole * std::pow(s[e] / largest, p);
  slopes.value = largest * std::pow(sum, 1 / p);
  for (std::size_t e = 0; e < n; ++e) {
    const double ratio = s[e] / slopes.value;
    slopes.by_measure[e] = volumes[e] / whole * std::pow(ratio, p - 1);
    slopes.by_volume[e] = slopes.value / p * (std::pow(ratio, p) - 1) / whole;
  }
  return slopes;
}

} // namespace

std::vector<double> equivalent_stress(std::span<const Stress> stress, StressMeasure measure) {
  std::vector<double> values;
  values.reserve(stress.size());
  for (const Stress& s : stress)
    values.push_back(measure == StressMeasure::von_mises ? von_mises(s) : max_shear(s));
  return values;
}

std::vector<double> displacement_sensitivity(const Mesh& mesh, const StaticModel& model,
                                             StaticAnalysis& analysis,
                                             std::span<const DesignVelocity> velocities) {
  SolvedProblem problem(mesh, model, analysis);
  std::vector<double> all;
  for_each_block(mesh, velocities, [&](std::size_t, auto own, const VelocityBlock& block) {
    const auto some = block_sensitivity(problem, own, block);
    all.insert(all.end(), some.begin(), some.end());
  });
  return all;
}

StressSensitivity stress_sensitivity(const Mesh& mesh, const StaticModel& model,
                                     StaticAnalysis& analysis,
                                     std::span<const DesignVelocity> velocities,
                                     const Progress& progress) {
  SolvedProblem problem(mesh, model, analysis);
  const auto& laws = problem.laws;
  const auto& u = analysis.solution.displacement;
  const std::size_t n = mesh.dofs(), elements = mesh.elements.size();
  StressSensitivity sensitivity;
  sensitivity.von_mises.resize(velocities.size() * elements);
  sensitivity.max_shear.resize(velocities.size() * elements);
  for_each_block(mesh, velocities, [&](std::size_t first, auto own, const VelocityBlock& block) {
    const auto du = block_sensitivity(problem, own, block);
    PointGradients at;
    for (std::size_t e = 0; e < elements; ++e) {
      const Element& element = mesh.elements[e];
      const auto nodes = mesh.nodes_of(element);
      const ElasticLaw& law = laws[static_cast<std::size_t>(element.region)];
      gradients(mesh, element, at_centroid(element.shape), at);
      const Tensor h = field_gradient(at, gather(u, nodes), nodes.size());
      const Stress stress = stress_of(law, h);
      const Stress mises = von_mises_slope(stress), shear = max_shear_slope(stress);
      for (std::size_t k = 0; k < block.count; ++k) {
        Tensor change =
            field_gradient(at, gather(std::span(du).subspan(k * n, n), nodes), nodes.size());
        const Tensor convected = h * block.gradient(at, nodes, k);
        for (std::size_t i = 0; i < 3; ++i)
          for (std::size_t j = 0; j < 3; ++j)
            change[i][j] -= convected[i][j];
        const Stress slope = stress_of(law, change);
        const std::size_t to = (first + k) * elements + e;
        sensitivity.von_mises[to] = static_cast<float>(product(mises, slope));
        sensitivity.max_shear[to] = static_cast<float>(product(shear, slope));
      }
    }
    if (progress)
      progress(static_cast<double>(first + block.count) / static_cast<double>(velocities.size()));
  });
  return sensitivity;
}

Gradient stress_scalar(const Mesh& mesh, const StaticModel& model, StaticAnalysis& analysis,
                       const StressScalar& scalar, std::span<const DesignVelocity> velocities) {
  const auto laws = elastic_laws(mesh, model.materials);
  const auto& u = analysis.solution.displacement;
  const auto stress = element_stress(mesh, model.materials, u);
  const ScalarSlopes slopes =
      slopes_of(scalar, equivalent_stress(stress, scalar.measure), element_volumes(mesh));
  NodeGradient gradient(mesh.nodes.size());
  std::vector<double> adjoint(mesh.dofs(), 0.0);
  PointGradients at;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const Element& element = mesh.elements[e];
    const auto nodes = mesh.nodes_of(element);
    const Stress slope = scalar.measure == StressMeasure::von_mises ? von_mises_slope(stress[e])
                                                                    : max_shear_slope(stress[e]);
    // tau = C slope: d measure = tau : d strain.
    const Tensor as_strain{
        {{slope[0], slope[5], slope[4]}, {0, slope[1], slope[3]}, {0, 0, slope[2]}}};
    const Tensor tau =
        to_tensor(stress_of(laws[static_cast<std::size_t>(element.region)], as_strain));
    gradients(mesh, element, at_centroid(element.shape), at);
    const Tensor convected =
        transposed_product(field_gradient(at, gather(u, nodes), nodes.size()), tau);
    const double weight = slopes.by_measure[e];
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const auto node = static_cast<std::size_t>(nodes[a]);
      const Vec3& g = at.slope[a];
      for (std::size_t i = 0; i < 3; ++i) {
        adjoint[3 * node + i] += weight * (tau[i][0] * g.x + tau[i][1] * g.y + tau[i][2] * g.z);
        gradient[node][static_cast<int>(i)] -=
            weight * (convected[i][0] * g.x + convected[i][1] * g.y + convected[i][2] * g.z);
      }
    }
  }
  add_volume_gradient(mesh, slopes.by_volume, gradient);
  for (std::size_t i = 0; i < adjoint.size(); ++i)
    if (analysis.system.matrices.constrained[i])
      adjoint[i] = 0;
  analysis.factor->solve(adjoint, adjoint, 1);
  add_internal_force_gradient(mesh, laws, u, adjoint, -1, gradient);
  add_gravity_gradient(mesh, laws, model.loads, adjoint, 1, gradient);
  Gradient result{slopes.value, by_parameter(gradient, velocities)};
  FaceForceDerivative faces(mesh, model);
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    const auto face = faces.along(velocities[k], u);
    for (std::size_t i = 0; i < face.size(); ++i)
      result.by_parameter[k] += adjoint[i] * face[i];
  }
  return result;
}

Gradient volume_gradient(const Mesh& mesh, std::span<const DesignVelocity> velocities) {
  NodeGradient gradient(mesh.nodes.size());
  add_volume_gradient(mesh, std::vector<double>(mesh.elements.size(), 1.0), gradient);
  return {volume(mesh), by_parameter(gradient, velocities)};
}

} // namespace tactus::fem
