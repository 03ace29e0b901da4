#include "fem/design/lattice.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

/// Smaller weights move a node by less than the rounding error.
constexpr double kNoWeight = 1e-12;

/// Clamped uniform knots: degree + 1 zeros, equal steps, degree + 1 ones.
std::vector<double> knots(int points, int degree) {
  std::vector<double> u(static_cast<std::size_t>(points + degree + 1), 0.0);
  for (int i = 0; i <= points + degree; ++i)
    u[static_cast<std::size_t>(i)] =
        std::clamp(static_cast<double>(i - degree) / (points - degree), 0.0, 1.0);
  return u;
}

/// All B-splines at t in [0, 1] (The NURBS Book, algorithm A2.2).
std::vector<double> basis(const std::vector<double>& u, int points, int degree, double t) {
  int span = degree;
  while (span < points - 1 && t >= u[static_cast<std::size_t>(span) + 1])
    ++span;
  std::vector<double> local(static_cast<std::size_t>(degree) + 1, 0.0);
  local[0] = 1;
  for (int j = 1; j <= degree; ++j) {
    double saved = 0;
    for (int r = 0; r < j; ++r) {
      const double right = u[static_cast<std::size_t>(span + r + 1)] - t;
      const double left = t - u[static_cast<std::size_t>(span + 1 - j + r)];
      const double part = local[static_cast<std::size_t>(r)] / (right + left);
      local[static_cast<std::size_t>(r)] = saved + right * part;
      saved = left * part;
    }
    local[static_cast<std::size_t>(j)] = saved;
  }
  std::vector<double> all(static_cast<std::size_t>(points), 0.0);
  for (int j = 0; j <= degree; ++j)
    all[static_cast<std::size_t>(span - degree + j)] = local[static_cast<std::size_t>(j)];
  return all;
}

void check_lattice(const Lattice& lattice) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::string axis(1, "xyz"[k]);
    const double low = lattice.box.low[static_cast<int>(k)],
                 high = lattice.box.high[static_cast<int>(k)];
    if (!(low < high) || !std::isfinite(low) || !std::isfinite(high))
      throw InputError("the lattice's box has no extent along " + axis + ", expected low < high");
    if (lattice.points[k] < 2 || lattice.points[k] > 64)
      throw InputError("the lattice has " + std::to_string(lattice.points[k]) +
                       " control points along " + axis + ", expected 2 to 64");
    if (lattice.degree[k] < 1 || lattice.degree[k] >= lattice.points[k])
      throw InputError("the lattice has the degree " + std::to_string(lattice.degree[k]) +
                       " along " + axis + ", expected 1 to " +
                       std::to_string(lattice.points[k] - 1) + " with its " +
                       std::to_string(lattice.points[k]) + " control points");
  }
}

} // namespace

ControlWeights embed(const Mesh& mesh, const Lattice& lattice) {
  check_lattice(lattice);
  const Vec3 size = lattice.box.size();
  std::array<std::vector<double>, 3> knot, greville;
  for (std::size_t k = 0; k < 3; ++k) {
    knot[k] = knots(lattice.points[k], lattice.degree[k]);
    for (int i = 0; i < lattice.points[k]; ++i) {
      double sum = 0;
      for (int j = 1; j <= lattice.degree[k]; ++j)
        sum += knot[k][static_cast<std::size_t>(i + j)];
      greville[k].push_back(sum / lattice.degree[k]);
    }
  }
  ControlWeights weights;
  for (const double z : greville[2])
    for (const double y : greville[1])
      for (const double x : greville[0])
        weights.control_points.push_back(lattice.box.low +
                                         Vec3{x * size.x, y * size.y, z * size.z});
  weights.start.push_back(0);
  bool any = false;
  for (const Vec3& p : mesh.nodes) {
    std::array<std::vector<double>, 3> own;
    bool inside = true;
    for (std::size_t k = 0; k < 3 && inside; ++k) {
      const int axis = static_cast<int>(k);
      const double t = (p[axis] - lattice.box.low[axis]) / size[axis];
      inside = t >= -1e-9 && t <= 1 + 1e-9;
      own[k] = basis(knot[k], lattice.points[k], lattice.degree[k], std::clamp(t, 0.0, 1.0));
    }
    for (int k = 0; inside && k < lattice.points[2]; ++k)
      for (int j = 0; j < lattice.points[1]; ++j)
        for (int i = 0; i < lattice.points[0]; ++i)
          if (const double w = own[0][static_cast<std::size_t>(i)] *
                               own[1][static_cast<std::size_t>(j)] *
                               own[2][static_cast<std::size_t>(k)];
              w > kNoWeight) {
            weights.control.push_back(lattice.control(i, j, k));
            weights.weight.push_back(w);
          }
    any = any || inside;
    weights.start.push_back(weights.control.size());
  }
  if (!any)
    throw InputError("no node of the mesh lies in the lattice's box");
  return weights;
}

ControlWeights import_weights(const Mesh& mesh, std::vector<Vec3> control_points,
                              std::span<const double> dense) {
  const std::size_t controls = control_points.size(), nodes = mesh.nodes.size();
  if (controls == 0 || dense.size() != controls * nodes)
    throw InputError("the weights have " + std::to_string(dense.size()) + " numbers, expected " +
                     std::to_string(nodes) + " nodes times " + std::to_string(controls) +
                     " control points");
  ControlWeights weights{std::move(control_points), {0}, {}, {}};
  for (std::size_t n = 0; n < nodes; ++n) {
    double sum = 0;
    for (std::size_t c = 0; c < controls; ++c) {
      const double w = dense[n * controls + c];
      sum += w;
      if (std::abs(w) > kNoWeight) {
        weights.control.push_back(static_cast<int>(c));
        weights.weight.push_back(w);
      }
    }
    if (!(std::abs(sum) < 1e-6 || std::abs(sum - 1) < 1e-6)) // also refuses NaN
      throw InputError("the weights of node " + std::to_string(n + 1) + " sum to " +
                       std::to_string(sum) + ", expected 1 (it moves with the cage) or 0");
    weights.start.push_back(weights.control.size());
  }
  return weights;
}

std::vector<ShapeParameter> free_parameters(std::span<const int> controls) {
  std::vector<ShapeParameter> parameters;
  for (const int c : controls)
    for (int k = 0; k < 3; ++k) {
      ShapeParameter& p = parameters.emplace_back();
      p.name = "cp " + std::to_string(c) + " " + "xyz"[k];
      p.controls = {c};
      p.direction[k] = 1;
    }
  return parameters;
}

std::vector<DesignVelocity> design_velocities(const ControlWeights& weights,
                                              std::span<const ShapeParameter> parameters) {
  std::vector<DesignVelocity> velocities;
  for (const ShapeParameter& parameter : parameters) {
    std::vector<double> share(weights.control_points.size(), 0.0);
    for (const int c : parameter.controls) {
      if (c < 0 || static_cast<std::size_t>(c) >= share.size())
        throw InputError("parameter " + parameter.name + " moves control point " +
                         std::to_string(c) + ", expected 0 to " + std::to_string(share.size() - 1));
      share[static_cast<std::size_t>(c)] = 1;
    }
    DesignVelocity& velocity = velocities.emplace_back();
    velocity.name = parameter.name;
    for (std::size_t n = 0; n + 1 < weights.start.size(); ++n) {
      double sum = 0;
      for (std::size_t k = weights.start[n]; k < weights.start[n + 1]; ++k)
        sum += share[static_cast<std::size_t>(weights.control[k])] * weights.weight[k];
      if (std::abs(sum) > kNoWeight) {
        velocity.node.push_back(static_cast<int>(n));
        velocity.velocity.push_back(sum * parameter.direction);
      }
    }
    if (velocity.node.empty() || !(length(parameter.direction) > 0) ||
        !std::isfinite(length(parameter.direction)))
      throw InputError("parameter " + parameter.name + " moves no node of the mesh");
  }
  return velocities;
}

std::vector<Vec3> moved_nodes(std::span<const Vec3> nodes,
                              std::span<const DesignVelocity> velocities,
                              std::span<const double> parameters) {
  if (parameters.size() != velocities.size())
    throw InputError("a shape has " + std::to_string(velocities.size()) + " parameters, got " +
                     std::to_string(parameters.size()));
  std::vector<Vec3> moved(nodes.begin(), nodes.end());
  for (std::size_t k = 0; k < velocities.size(); ++k) {
    if (!std::isfinite(parameters[k]))
      throw InputError("parameter " + velocities[k].name + ": not a finite number");
    for (std::size_t i = 0; parameters[k] != 0 && i < velocities[k].node.size(); ++i)
      moved[static_cast<std::size_t>(velocities[k].node[i])] +=
          parameters[k] * velocities[k].velocity[i];
  }
  return moved;
}

} // namespace tactus::fem
