#include "fem/design/shape_gradient.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// Step relative to the mean element size, at which truncation (1e-10) and rounding (1e-11) of the
/// difference are similar.
constexpr double kRelativeStep = 1e-5;

/// into_b += weight P grad N_b.
void add_tensor(const PointGradients& at, std::span<const int> nodes, const Tensor& p,
                double weight, NodeGradient& into) {
  for (std::size_t b = 0; b < nodes.size(); ++b) {
    Vec3& to = into[static_cast<std::size_t>(nodes[b])];
    const Vec3& g = at.slope[b];
    for (int k = 0; k < 3; ++k) {
      const auto& row = p[static_cast<std::size_t>(k)];
      to[k] += weight * (row[0] * g.x + row[1] * g.y + row[2] * g.z);
    }
  }
}

constexpr Tensor kIdentity{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};

/// Adds factor(element, shape values) d(dV)/dX at the mass points of every element.
template <class Factor>
void add_scaled_volume(const Mesh& mesh, NodeGradient& into, Factor&& factor) {
  PointGradients at;
  for (std::size_t k = 0; k < mesh.elements.size(); ++k) {
    const Element& e = mesh.elements[k];
    const Tabulated& table = at_mass_points(e.shape);
    for (std::size_t q = 0; q < table.weights.size(); ++q) {
      gradients(mesh, e, table.values[q], at);
      add_tensor(at, mesh.nodes_of(e), kIdentity,
                 table.weights[q] * at.determinant * factor(k, table.values[q]), into);
    }
  }
}

/// A field of nodal vectors at a point of an element.
Vec3 field_at(std::span<const double> u, std::span<const int> nodes, const ShapeValues& values) {
  Vec3 sum;
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const double* own = &u[3 * static_cast<std::size_t>(nodes[a])];
    sum += values.value[a] * Vec3{own[0], own[1], own[2]};
  }
  return sum;
}

} // namespace

std::vector<double> by_parameter(const NodeGradient& gradient,
                                 std::span<const DesignVelocity> velocities) {
  std::vector<double> sums;
  for (const DesignVelocity& v : velocities) {
    double sum = 0;
    for (std::size_t i = 0; i < v.node.size(); ++i)
      sum += dot(gradient[static_cast<std::size_t>(v.node[i])], v.velocity[i]);
    sums.push_back(sum);
  }
  return sums;
}

void add_internal_force_gradient(const Mesh& mesh, std::span<const ElasticLaw> laws,
                                 std::span<const double> u, std::span<const double> v,
                                 double factor, NodeGradient& into) {
  PointGradients at;
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    const ElasticLaw& law = laws[static_cast<std::size_t>(e.region)];
    const ElementField own_u = gather(u, nodes), own_v = gather(v, nodes);
    const Tabulated& table = at_stiffness_points(e.shape);
    for (std::size_t q = 0; q < table.weights.size(); ++q) {
      gradients(mesh, e, table.values[q], at);
      const Tensor h = field_gradient(at, own_u, nodes.size());
      const Tensor g = field_gradient(at, own_v, nodes.size());
      const Tensor sigma = to_tensor(stress_of(law, h)), s = to_tensor(stress_of(law, g));
      const Tensor first = transposed_product(h, s), second = transposed_product(g, sigma);
      const double energy = contraction(sigma, g);
      Tensor p{};
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          p[i][j] = (i == j ? energy : 0) - first[i][j] - second[i][j];
      add_tensor(at, nodes, p, factor * table.weights[q] * at.determinant, into);
    }
  }
}

void add_mass_gradient(const Mesh& mesh, std::span<const ElasticLaw> laws,
                       std::span<const double> u, std::span<const double> v, double factor,
                       NodeGradient& into) {
  add_scaled_volume(mesh, into, [&](std::size_t k, const ShapeValues& values) {
    const Element& e = mesh.elements[k];
    const auto nodes = mesh.nodes_of(e);
    return factor * laws[static_cast<std::size_t>(e.region)].density *
           dot(field_at(u, nodes, values), field_at(v, nodes, values));
  });
}

void add_volume_gradient(const Mesh& mesh, std::span<const double> factor, NodeGradient& into) {
  add_scaled_volume(mesh, into, [&](std::size_t k, const ShapeValues&) { return factor[k]; });
}

void add_gravity_gradient(const Mesh& mesh, std::span<const ElasticLaw> laws,
                          std::span<const Load> loads, std::span<const double> v, double factor,
                          NodeGradient& into) {
  Vec3 acceleration;
  bool any = false;
  for (const Load& load : loads)
    if (const auto* gravity = std::get_if<Gravity>(&load)) {
      acceleration += gravity->acceleration;
      any = true;
    }
  if (any)
    add_scaled_volume(mesh, into, [&](std::size_t k, const ShapeValues& values) {
      const Element& e = mesh.elements[k];
      return factor * laws[static_cast<std::size_t>(e.region)].density *
             dot(field_at(v, mesh.nodes_of(e), values), acceleration);
    });
}

FaceForceDerivative::FaceForceDerivative(const Mesh& mesh, const StaticModel& model)
    : mesh_(mesh), materials_(model.materials), springs_(model.springs),
      on_face_(mesh.nodes.size(), 0),
      size_(std::cbrt(volume(mesh) / static_cast<double>(mesh.elements.size()))) {
  const auto mark = [&](std::span<const MeshFace> faces) {
    for (const int n : nodes_of_faces(mesh, faces))
      on_face_[static_cast<std::size_t>(n)] = 1;
  };
  for (const Load& load : model.loads)
    std::visit(
        [&](const auto& own) {
          if constexpr (requires { own.faces; }) {
            mark(own.faces);
            loads_.push_back(load);
          }
        },
        load);
  for (const SpringPatch& spring : springs_)
    mark(spring.faces);
}

std::vector<double> FaceForceDerivative::along(const DesignVelocity& velocity,
                                               std::span<const double> u) {
  double fastest = 0;
  bool moves = false;
  for (std::size_t i = 0; i < velocity.node.size(); ++i) {
    fastest = std::max(fastest, length(velocity.velocity[i]));
    moves = moves || on_face_[static_cast<std::size_t>(velocity.node[i])];
  }
  if (!moves)
    return {};
  const double step = kRelativeStep * size_ / fastest;
  const std::vector<Vec3> nodes = mesh_.nodes;
  std::vector<double> difference(mesh_.dofs(), 0.0);
  for (const double side : {1.0, -1.0}) {
    for (std::size_t i = 0; i < velocity.node.size(); ++i) {
      const auto n = static_cast<std::size_t>(velocity.node[i]);
      mesh_.nodes[n] = nodes[n] + side * step * velocity.velocity[i];
    }
    const auto force = load_vector(mesh_, materials_, loads_);
    const auto constrained = spring_forces(mesh_, springs_, u);
    for (std::size_t i = 0; i < difference.size(); ++i)
      difference[i] += side * (force[i] - constrained[i]) / (2 * step);
  }
  mesh_.nodes = nodes;
  return difference;
}

} // namespace tactus::fem
