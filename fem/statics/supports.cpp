#include "fem/statics/supports.hpp"

#include "fem/io/text.hpp"
#include "fem/modes/dense.hpp"
#include "fem/statics/face_points.hpp"
#include "fem/statics/loads.hpp"
#include "fem/statics/selection.hpp"

#include <algorithm>
#include <cmath>
#include <string>

namespace tactus::fem {
namespace {

void check_springs(const Mesh& mesh, const SpringPatch& spring) {
  const std::string label = "spring " + spring.name;
  check_faces(mesh, spring.faces, label);
  for (int i = 0; i < 3; ++i)
    if (!(spring.stiffness_n_per_m[i] >= 0) || !std::isfinite(spring.stiffness_n_per_m[i]))
      throw InputError(label + " has the stiffness " + std::to_string(spring.stiffness_n_per_m[i]) +
                       " N/m along " + "xyz"[i] + ", expected 0 or more");
}

/// The constraints on the six rigid motions of one piece, a translation by t and a rotation by w /
/// radius about `centre`.
struct Piece {
  Vec3 centre, constrained_centre;
  double nodes = 0, radius = 0, constrained = 0;
  std::array<double, 36> constraint{};
  int region = 0;

  /// Adds the square of the motion of a point in direction i.
  void add(const Vec3& point, int i, double weight) {
    Vec3 direction;
    direction[i] = 1;
    // direction . (t + w x arm) = direction . t + (arm x direction) . w
    const Vec3 turn = cross((1 / radius) * (point - centre), direction);
    const std::array<double, 6> row{direction.x, direction.y, direction.z, turn.x, turn.y, turn.z};
    for (std::size_t a = 0; a < 6; ++a)
      for (std::size_t b = 0; b < 6; ++b)
        constraint[6 * b + a] += weight * row[a] * row[b];
    constrained_centre += weight * point;
    constrained += weight;
  }
};

/// Removes rounding errors: components below 1e-9 of `scale` become zero.
Vec3 without_rounding(Vec3 v, double scale) {
  for (int i = 0; i < 3; ++i)
    if (std::abs(v[i]) < 1e-9 * scale)
      v[i] = 0;
  return v;
}

/// A text such as "y" or "(0.8, 0.6, 0)"; the first component that is not zero is positive.
std::string direction(const Vec3& v) {
  Vec3 d = without_rounding((1 / length(v)) * v, 1);
  for (int i = 0; i < 3; ++i)
    if (d[i] != 0) {
      d = d[i] < 0 ? Vec3{} - d : d; // no -0
      break;
    }
  for (int i = 0; i < 3; ++i)
    if (d[i] > 1 - 1e-9)
      return std::string(1, "xyz"[i]);
  return format("(%.3g, %.3g, %.3g)", d.x, d.y, d.z);
}

/// A text such as "a rotation about y through (1, 0, 2) mm". If several motions are free, it
/// describes the simplest, a translation or a rotation about an axis parallel to x, y or z.
std::string describe(const Piece& piece, std::span<const double> null_space, std::size_t count) {
  const Vec3 centre =
      piece.constrained > 0 ? (1 / piece.constrained) * piece.constrained_centre : piece.centre;
  std::array<double, 6> motion{};
  std::copy_n(null_space.begin(), 6, motion.begin());
  for (int k = 0; k < 6 && count > 1; ++k) {
    Vec3 axis;
    axis[k % 3] = 1;
    // e x (x - c) = e x (x - centre of the piece) + e x (centre of the piece - c)
    const Vec3 shift = k < 3 ? axis : cross(axis, (1 / piece.radius) * (piece.centre - centre));
    std::array<double, 6> trial{shift.x, shift.y, shift.z, 0, 0, 0};
    if (k >= 3)
      trial[static_cast<std::size_t>(k)] = 1;
    double norm = 0, inside = 0;
    for (const double m : trial)
      norm += m * m;
    for (std::size_t c = 0; c < count; ++c) {
      double along = 0;
      for (std::size_t i = 0; i < 6; ++i)
        along += null_space[6 * c + i] * trial[i];
      inside += along * along;
    }
    if (inside > (1 - 1e-9) * norm) {
      motion = trial;
      break;
    }
  }
  const Vec3 t{motion[0], motion[1], motion[2]};
  const Vec3 w = (1 / piece.radius) * Vec3{motion[3], motion[4], motion[5]};
  const double turn = length(w);
  if (turn * piece.radius < 1e-9)
    return "a translation along " + direction(t);
  const Vec3 through = without_rounding(1e3 * (piece.centre + (1 / (turn * turn)) * cross(w, t)),
                                        1e3 * piece.radius);
  return "a rotation about " + direction(w) +
         format(" through (%.4g, %.4g, %.4g) mm", through.x, through.y, through.z);
}

void check_fixed(const Mesh& mesh, const FixedPatch& patch) {
  const std::string label = "support " + patch.name;
  if (patch.nodes.empty())
    throw InputError(label + " selects no node, expected a region of the body");
  for (const int n : patch.nodes)
    if (n < 0 || static_cast<std::size_t>(n) >= mesh.nodes.size())
      throw InputError(label + " fixes node " + std::to_string(n + 1) + ", the mesh has " +
                       std::to_string(mesh.nodes.size()));
  if (!patch.directions[0] && !patch.directions[1] && !patch.directions[2])
    throw InputError(label + " fixes no direction, expected x, y or z");
  for (int i = 0; i < 3; ++i)
    if (!std::isfinite(patch.displacement_m[i]))
      throw InputError(label + ": displacement is not a finite number");
}

} // namespace

std::vector<std::uint8_t> held_directions(const Mesh& mesh, std::span<const FixedPatch> fixed) {
  std::vector<std::uint8_t> held(mesh.dofs(), 0);
  for (const FixedPatch& patch : fixed)
    for (const int node : patch.nodes)
      for (std::size_t i = 0; i < 3; ++i)
        held[3 * static_cast<std::size_t>(node) + i] |= patch.directions[i];
  return held;
}

void add_springs(const Mesh& mesh, std::span<const SpringPatch> springs, Matrices& into) {
  for (const SpringPatch& spring : springs) {
    check_springs(mesh, spring);
    const double whole = area(mesh, spring.faces);
    for (const MeshFace& face : spring.faces) {
      const FaceNodes nodes = face_nodes(mesh, face);
      for (const FacePoint& p : face_points(mesh, face))
        for (std::size_t a = 0; a < nodes.count; ++a)
          for (std::size_t b = 0; b < nodes.count; ++b) {
            if (nodes.node[a] < nodes.node[b])
              continue;
            double* block =
                &into.stiffness[9 * into.graph.find(static_cast<std::int64_t>(nodes.node[a]),
                                                    static_cast<std::int64_t>(nodes.node[b]))];
            for (int i = 0; i < 3; ++i)
              block[4 * i] +=
                  spring.stiffness_n_per_m[i] / whole * length(p.area) * p.value[a] * p.value[b];
          }
    }
  }
}

std::vector<double> spring_forces(const Mesh& mesh, std::span<const SpringPatch> springs,
                                  std::span<const double> u) {
  std::vector<double> f(u.size(), 0.0);
  for (const SpringPatch& spring : springs) {
    const double whole = area(mesh, spring.faces);
    for (const MeshFace& face : spring.faces) {
      const FaceNodes nodes = face_nodes(mesh, face);
      for (const FacePoint& p : face_points(mesh, face))
        for (std::size_t i = 0; i < 3; ++i) {
          double moved = 0;
          for (std::size_t a = 0; a < nodes.count; ++a)
            moved += p.value[a] * u[3 * nodes.node[a] + i];
          for (std::size_t a = 0; a < nodes.count; ++a)
            f[3 * nodes.node[a] + i] += spring.stiffness_n_per_m[static_cast<int>(i)] / whole *
                                        length(p.area) * p.value[a] * moved;
        }
    }
  }
  return f;
}

void check_supported(const Mesh& mesh, std::span<const FixedPatch> fixed,
                     std::span<const SpringPatch> springs) {
  for (const FixedPatch& patch : fixed)
    check_fixed(mesh, patch);
  for (const SpringPatch& spring : springs)
    check_springs(mesh, spring);
  const Parts parts = connected_parts(mesh);
  std::vector<Piece> pieces(static_cast<std::size_t>(parts.count));
  const auto piece_of = [&](std::size_t node) -> Piece& {
    return pieces[static_cast<std::size_t>(parts.of_node[node])];
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    piece_of(n).centre += mesh.nodes[n];
    piece_of(n).nodes += 1;
  }
  for (Piece& piece : pieces)
    piece.centre = (1 / std::max(piece.nodes, 1.0)) * piece.centre;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    Piece& piece = piece_of(n);
    piece.radius = std::max(piece.radius, length(mesh.nodes[n] - piece.centre));
  }
  for (const Element& e : mesh.elements)
    piece_of(static_cast<std::size_t>(mesh.nodes_of(e)[0])).region = e.region;

  for (const FixedPatch& patch : fixed)
    for (const int n : patch.nodes)
      for (int i = 0; i < 3; ++i)
        if (patch.directions[static_cast<std::size_t>(i)])
          piece_of(static_cast<std::size_t>(n)).add(mesh.nodes[static_cast<std::size_t>(n)], i, 1);
  for (const SpringPatch& spring : springs)
    for (const int n : nodes_of_faces(mesh, spring.faces))
      for (int i = 0; i < 3; ++i)
        if (spring.stiffness_n_per_m[i] > 0)
          piece_of(static_cast<std::size_t>(n)).add(mesh.nodes[static_cast<std::size_t>(n)], i, 1);

  for (std::size_t k = 0; k < pieces.size(); ++k) {
    const Piece& piece = pieces[k];
    if (piece.nodes == 0)
      continue;
    const Eigenpairs motions = symmetric_eigenpairs(piece.constraint, 6);
    const double largest = std::max(motions.values.back(), 1.0);
    std::size_t free = 0;
    while (free < 6 && motions.values[free] < 1e-12 * largest)
      ++free;
    if (free == 0)
      continue;
    std::string part_label =
        pieces.size() == 1
            ? "the body"
            : format("piece %zu of %zu (%s, around (%.4g, %.4g, %.4g) mm)", k + 1, pieces.size(),
                     mesh.regions[static_cast<std::size_t>(piece.region)].c_str(),
                     1e3 * piece.centre.x, 1e3 * piece.centre.y, 1e3 * piece.centre.z);
    throw InputError(part_label + " is not fully supported: " + std::to_string(free) +
                     " of its 6 rigid motions are free, among them " +
                     describe(piece, motions.vectors, free) + "; add a support or a spring");
  }
}

} // namespace tactus::fem
