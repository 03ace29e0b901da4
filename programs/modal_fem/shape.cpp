#include "programs/modal_fem/shape.hpp"

#include "fem/design/eigenvalue_sensitivity.hpp"
#include "fem/design/valid_step.hpp"
#include "fem/io/words.hpp"

#include <algorithm>

namespace tactus::fem {
namespace {

constexpr int kMaxPoints = 32;
constexpr double kMinInfluence = 1e-3; // of a node's motion in its control point's
constexpr double kTrustShare = .1;     // of the lattice's shortest side

double number(const std::string& option, const std::string& word, double low, double high) {
  const auto value = to_number(word);
  if (!value || !(*value >= low && *value <= high))
    throw Refusal(option + " " + printable(word, 20) +
                  format(": expected a number from %g to %g", low, high));
  return *value;
}

int whole_number(const std::string& option, const std::string& word, int low, int high) {
  const double value = number(option, word, low, high);
  if (value != std::floor(value))
    throw Refusal(option + " " + printable(word, 20) + ": expected a whole number");
  return static_cast<int>(value);
}

Box read_box(const std::string& words, double unit) {
  const auto cells = split(words, ',');
  if (cells.size() != 6)
    throw Refusal("--box " + printable(words, 60) + ": expected X1,Y1,Z1,X2,Y2,Z2");
  Box box;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    box.low[k] = unit * number("--box", cells[at], -1e9, 1e9);
    box.high[k] = unit * number("--box", cells[at + 3], -1e9, 1e9);
    if (!(box.low[k] < box.high[k]))
      throw Refusal("--box " + printable(words, 60) +
                    ": expected each coordinate of the second corner above the first's");
  }
  return box;
}

/// Per axis and side: the body goes on beyond this face of the box.
std::array<std::array<bool, 2>, 3> passed_faces(const Mesh& mesh, const Box& box) {
  const double near = 1e-6 * bounding_box(mesh.nodes).largest();
  const auto beyond = [&](const Vector3& p, int axis, std::size_t side) {
    return side == 0 ? p[axis] < box.low[axis] - near : p[axis] > box.high[axis] + near;
  };
  const auto is_inside = [&](const Vector3& p) {
    for (int axis = 0; axis < 3; ++axis)
      if (beyond(p, axis, 0) || beyond(p, axis, 1))
        return false;
    return true;
  };
  std::array<std::array<bool, 2>, 3> passed{};
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    const auto place = [&](int n) -> const Vector3& {
      return mesh.nodes[static_cast<std::size_t>(n)];
    };
    if (std::none_of(nodes.begin(), nodes.end(), [&](int n) { return is_inside(place(n)); }))
      continue;
    for (int axis = 0; axis < 3; ++axis)
      for (std::size_t side = 0; side < 2; ++side)
        if (std::any_of(nodes.begin(), nodes.end(),
                        [&](int n) { return beyond(place(n), axis, side); }))
          passed[static_cast<std::size_t>(axis)][side] = true;
  }
  return passed;
}

/// The control points that may move.
std::vector<int> movable(const Mesh& mesh, const Lattice& lattice, const ControlWeights& weights) {
  std::vector<double> influence(static_cast<std::size_t>(lattice.control_count()), 0);
  for (std::size_t i = 0; i < weights.control.size(); ++i) {
    double& most = influence[static_cast<std::size_t>(weights.control[i])];
    most = std::max(most, std::abs(weights.weight[i]));
  }
  const auto passed = passed_faces(mesh, lattice.box);
  std::vector<int> found;
  for (int c = 0; c < lattice.control_count(); ++c) {
    bool moves = influence[static_cast<std::size_t>(c)] >= kMinInfluence;
    int rest = c;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      const int at = rest % lattice.points[axis];
      rest /= lattice.points[axis];
      moves &=
          !(passed[axis][0] && at == 0) && !(passed[axis][1] && at == lattice.points[axis] - 1);
    }
    if (moves)
      found.push_back(c);
  }
  return found;
}

std::vector<int> chosen_of(const ShapeOrder& order, const Lattice& lattice,
                           const std::vector<int>& may_move) {
  if (may_move.empty())
    throw Refusal("--box: no control point may move, as the body passes through the faces of the "
                  "box on which they lie: expected more points (--lattice) or another box");
  for (const int c : order.controls)
    if (c >= lattice.control_count())
      throw Refusal(format("--controls: control point %d is not there, expected 0 to %d", c,
                           lattice.control_count() - 1));
    else if (!std::binary_search(may_move.begin(), may_move.end(), c))
      throw Refusal(format("--controls: control point %d cannot move: it moves no node, or lies on "
                           "a face of the box that the body passes through",
                           c));
  std::vector<int> chosen = order.controls.empty() ? may_move : order.controls;
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

} // namespace

bool ShapeOrder::take(const std::string& option, const std::function<const std::string&()>& value,
                      double unit) {
  if (option == "--box") {
    box = read_box(value(), unit);
  } else if (option == "--lattice") {
    for (int& count : points)
      count = whole_number(option, value(), 2, kMaxPoints);
  } else if (option == "--degree") {
    for (int& d : degree)
      d = whole_number(option, value(), 1, kMaxPoints - 1);
  } else if (option == "--controls") {
    for (const std::string& cell : split(value(), ','))
      controls.push_back(whole_number(option, cell, 0, kMaxPoints * kMaxPoints * kMaxPoints));
  } else if (option == "--directions") {
    const std::string& word = value();
    directions = {};
    for (const char c : word) {
      if (c < 'x' || c > 'z')
        throw Refusal(option + " " + printable(word, 20) +
                      ": expected directions out of x, y and z");
      directions[static_cast<std::size_t>(c - 'x')] = true;
    }
  } else if (option == "--range") {
    range = unit * number(option, value(), 1e-9, 1e9);
  } else if (option == "--trust") {
    trust = unit * number(option, value(), 1e-9, 1e9);
  } else {
    return false;
  }
  return wanted = true;
}

ShapeDerivatives shape_derivatives(const ShapeOrder& order, const Mesh& mesh,
                                   std::span<const Material> materials, const Modes& modes,
                                   std::size_t count, ProgressLine& progress) {
  progress.stage("how the modes follow the shape", 0);
  Lattice lattice{order.box ? *order.box : bounding_box(mesh.nodes), order.points, order.degree};
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (order.degree[axis] == 0)
      lattice.degree[axis] = std::min(3, order.points[axis] - 1);
  const ControlWeights weights = embed(mesh, lattice);
  const Vector3 side = lattice.box.size();
  ShapeDerivatives out;
  out.control_points = weights.control_points;
  out.trust = order.trust > 0 ? order.trust : kTrustShare * std::min({side.x, side.y, side.z});
  std::vector<ShapeParameter> parameters;
  for (const int control : chosen_of(order, lattice, movable(mesh, lattice, weights)))
    for (int axis = 0; axis < 3; ++axis)
      if (const auto a = static_cast<std::size_t>(axis); order.directions[a]) {
        Vector3 direction;
        direction[axis] = 1;
        parameters.push_back({format("%d %c", control, 'x' + axis), {control}, direction});
        const double spacing = side[axis] / (lattice.points[a] - 1);
        const double range = order.range > 0 ? order.range : spacing / 2;
        out.parameters.push_back({control, axis, -range, range});
      }
  if (parameters.empty())
    throw Refusal("--directions: expected one of x, y and z or more");
  const std::vector<DesignVelocity> velocities = design_velocities(weights, parameters);
  for (std::size_t p = 0; p < velocities.size(); ++p)
    for (double* bound : {&out.parameters[p].low, &out.parameters[p].high}) {
      const auto target =
          moved_nodes(mesh.nodes, std::span(&velocities[p], 1), std::span(bound, 1));
      *bound *= valid_step(mesh, target).fraction;
    }
  out.by_parameter = eigenvalue_sensitivity(mesh, materials, {}, modes.frequency_hz, modes.shapes,
                                            count, velocities);
  return out;
}

} // namespace tactus::fem
