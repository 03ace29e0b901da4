#include "programs/body/design_space.hpp"

#include "fem/design/valid_step.hpp"
#include "fem/io/text.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

constexpr double kTrustShare = .1; ///< relative to the lattice's shortest side

std::array<int, 3> read_counts(BodyReader& reader, int low, int high) {
  std::array<int, 3> counts{};
  for (int& count : counts) {
    const std::string& word = reader.value();
    const auto value = to_number<int>(word);
    if (!value || *value < low || *value > high)
      throw InputError(reader.option() + " " + printable(word, 20) +
                       format(": expected three integers in %d..%d", low, high));
    count = *value;
  }
  return counts;
}

Box read_box(const std::string& words, double unit) {
  const auto cells = split(words, ',');
  if (cells.size() != 6)
    throw InputError("--box " + printable(words, 60) + ": expected X1,Y1,Z1,X2,Y2,Z2");
  Box box;
  for (int k = 0; k < 3; ++k) {
    const auto at = static_cast<std::size_t>(k);
    box.low[k] = unit * number("--box", cells[at], -1e9, 1e9);
    box.high[k] = unit * number("--box", cells[at + 3], -1e9, 1e9);
    if (!(box.low[k] < box.high[k]))
      throw InputError("--box " + printable(words, 60) +
                       ": expected each coordinate of the second corner above the first's");
  }
  return box;
}

/// For each face of the box, [axis][low, high]: whether the body passes through it.
std::array<std::array<bool, 2>, 3> faces_passed(const Mesh& mesh, const Box& box) {
  const double near = 1e-6 * bounding_box(mesh.nodes).largest();
  std::array<std::array<bool, 2>, 3> passed{};
  const auto outside = [&](const Vec3& p, int k) {
    return p[k] < box.low[k] - near ? -1 : p[k] > box.high[k] + near ? 1 : 0;
  };
  for (const Element& e : mesh.elements) {
    // An element with a node inside connects the part beyond a face to the moving part.
    bool inside = false;
    for (const int n : mesh.nodes_of(e)) {
      const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
      inside |= outside(p, 0) == 0 && outside(p, 1) == 0 && outside(p, 2) == 0;
    }
    if (!inside)
      continue;
    for (const int n : mesh.nodes_of(e))
      for (int k = 0; k < 3; ++k)
        if (const int side = outside(mesh.nodes[static_cast<std::size_t>(n)], k); side != 0)
          passed[static_cast<std::size_t>(k)][side > 0] = true;
  }
  return passed;
}

std::vector<int> free_controls(const DesignOptions& options, const Mesh& mesh,
                               const DesignSpace& space) {
  const Lattice& lattice = space.lattice;
  std::vector<double> influence(static_cast<std::size_t>(lattice.control_count()), 0);
  for (std::size_t i = 0; i < space.weights.control.size(); ++i) {
    double& max_weight = influence[static_cast<std::size_t>(space.weights.control[i])];
    max_weight = std::max(max_weight, std::abs(space.weights.weight[i]));
  }
  constexpr double kMinInfluence =
      1e-3; // smallest motion of a node relative to the control point's
  const auto passed = faces_passed(mesh, lattice.box);
  std::vector<int> found;
  for (int k = 0; k < lattice.points[2]; ++k)
    for (int j = 0; j < lattice.points[1]; ++j)
      for (int i = 0; i < lattice.points[0]; ++i) {
        const std::array<int, 3> at{i, j, k};
        bool stays = influence[static_cast<std::size_t>(lattice.control(i, j, k))] < kMinInfluence;
        for (std::size_t a = 0; a < 3; ++a)
          stays |= (passed[a][0] && at[a] == 0) || (passed[a][1] && at[a] == lattice.points[a] - 1);
        if (!stays)
          found.push_back(lattice.control(i, j, k));
      }
  if (options.controls.empty())
    return found;
  for (const int id : options.controls)
    if (std::find(found.begin(), found.end(), id) == found.end())
      throw InputError(
          format("--controls: control point %d", id) +
          (id >= lattice.control_count()
               ? format(": expected 0..%d", lattice.control_count() - 1)
               : " cannot move: it moves no node, or lies on a face of the box that the "
                 "body passes through"));
  std::vector<int> chosen = options.controls;
  std::sort(chosen.begin(), chosen.end());
  chosen.erase(std::unique(chosen.begin(), chosen.end()), chosen.end());
  return chosen;
}

/// The largest displacement, up to `requested` of either sign, that is valid if no other parameter
/// moves.
double valid_bound(const Mesh& mesh, const DesignVelocity& velocity, double requested) {
  std::vector<Vec3> target =
      moved_nodes(mesh.nodes, std::span(&velocity, 1), std::span(&requested, 1));
  return requested * valid_step(mesh, target).fraction;
}

} // namespace

std::array<bool, 3> read_directions(const std::string& option, const std::string& word) {
  std::array<bool, 3> directions{};
  for (const char c : word) {
    if (c < 'x' || c > 'z')
      throw InputError(option + " " + printable(word, 20) +
                       ": expected directions such as x, yz or xyz");
    directions[static_cast<std::size_t>(c - 'x')] = true;
  }
  if (word.empty())
    throw InputError(option + ": expected directions such as x, yz or xyz");
  return directions;
}

bool DesignOptions::take(BodyReader& reader) {
  constexpr int kMaxPoints = 32;
  const std::string& option = reader.option();
  if (option == "--box") {
    box = read_box(reader.value(), reader.unit());
  } else if (option == "--lattice") {
    points = read_counts(reader, 2, kMaxPoints);
  } else if (option == "--degree") {
    degree = read_counts(reader, 1, kMaxPoints - 1);
  } else if (option == "--controls") {
    for (const std::string& cell : split(reader.value(), ',')) {
      const auto id = to_number<int>(cell);
      if (!id || *id < 0)
        throw InputError("--controls " + printable(cell, 20) +
                         ": expected numbers of control points, 0 or more, between commas");
      controls.push_back(*id);
    }
  } else if (option == "--directions") {
    directions = read_directions(option, reader.value());
  } else if (option == "--range") {
    range = reader.length(1e-9, 1e9);
  } else if (option == "--trust") {
    trust = reader.length(1e-9, 1e9);
  } else {
    return false;
  }
  return requested = true;
}

DesignSpace design_space_of(const DesignOptions& options, const Mesh& mesh) {
  DesignSpace space;
  space.lattice.box = options.box ? *options.box : bounding_box(mesh.nodes);
  space.lattice.points = options.points;
  for (std::size_t a = 0; a < 3; ++a)
    space.lattice.degree[a] =
        options.degree[a] > 0 ? options.degree[a] : std::min(3, options.points[a] - 1);
  space.weights = embed(mesh, space.lattice);
  space.controls = free_controls(options, mesh, space);
  if (space.controls.empty())
    throw InputError(
        "--box: no control point may move, as the body passes through the faces of the "
        "box on which they lie: expected more points (--lattice) or another box");
  const Vec3 side = space.lattice.box.size();
  space.trust =
      options.trust > 0 ? options.trust : kTrustShare * std::min({side.x, side.y, side.z});
  std::vector<ShapeParameter> parameters;
  for (const int control : space.controls)
    for (int axis = 0; axis < 3; ++axis)
      if (options.directions[static_cast<std::size_t>(axis)]) {
        Vec3 direction;
        direction[axis] = 1;
        parameters.push_back(
            {format("%d %c", control, 'x' + axis), std::vector<int>{control}, direction});
        const double spacing = side[axis] / (options.points[static_cast<std::size_t>(axis)] - 1);
        const double range = options.range > 0 ? options.range : spacing / 2;
        space.parameters.push_back({control, axis, -range, range});
      }
  if (parameters.empty())
    throw InputError("--directions: expected directions such as x, yz or xyz");
  space.velocities = design_velocities(space.weights, parameters);
  for (std::size_t p = 0; p < space.parameters.size(); ++p) {
    ParameterRange& range = space.parameters[p];
    range.low = valid_bound(mesh, space.velocities[p], range.low);
    range.high = valid_bound(mesh, space.velocities[p], range.high);
  }
  return space;
}

void DesignSpace::check_within_bounds(std::span<const double> values) const {
  for (std::size_t p = 0; p < parameters.size(); ++p) {
    const ParameterRange& range = parameters[p];
    const double rounding = 1e-6 * (range.high - range.low);
    if (!std::isfinite(values[p]))
      throw InputError(format("control point %d along %c: not a finite number", range.control,
                              'x' + range.axis));
    if (!(values[p] >= range.low - rounding && values[p] <= range.high + rounding))
      throw InputError(format("control point %d along %c %.6g mm: expected %.6g..%.6g mm",
                              range.control, 'x' + range.axis, 1e3 * values[p], 1e3 * range.low,
                              1e3 * range.high));
  }
}

std::string usage_of_lattice() {
  return R"(Shape         --lattice NX NY NZ (3 3 3)  control points that reshape the body
              --box X1,Y1,Z1,X2,Y2,Z2 (the body's)  box spanned by the lattice
              --degree DX DY DZ (3, or one less than the points)
              --controls ID,ID,...  movable control points (all that keep the body in one piece)
              --directions xyz      directions in which they move
              --range LENGTH (half a spacing)  bounds of each coordinate
              --trust LENGTH (a tenth of the box)  largest move for which derivatives are valid
)";
}

} // namespace tactus::fem
