#include "programs/part_stress/part.hpp"

#include "fem/io/words.hpp"
#include "fem/modes/cost.hpp"
#include "programs/part_stress/petsc_engine.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tactus::fem {
namespace {

constexpr double kUsualElements =
    2200; ///< asked of a file; curved faces take two to four times as many
constexpr double kTetrahedronShare = .118; ///< volume of a regular tetrahedron of edge 1
constexpr int kElementsPerTurn = 6;        ///< around curved faces; their sides are curved too

/// Of K here while it is exported, and of K, its levels and the vectors in PETSc's processes
/// (measured, docs/part_stress.md); and of the libraries of one process.
constexpr double kPetscPairBytes = 900, kPetscProcessBytes = 7e7;

/// Bytes of the factor, the matrix and its graph, the mesh, and the sensitivities.
double bytes_of(const MeshSize& size, const PartOrder& order) {
  if (order.petsc) { // more processes than have work are refused when the mesh is known
    const double most = size.nodes / static_cast<double>(kMinNodesPerProcess);
    return size.node_pairs * kPetscPairBytes +
           std::min<double>(order.ranks, most) * kPetscProcessBytes + 5e7;
  }
  const double controls = order.design.points[0] * order.design.points[1] * order.design.points[2];
  const double parameters = order.output.empty() && order.moves.empty() ? 0 : 3 * controls;
  return foretell_factor(size).memory_bytes + size.node_pairs * (9 + 1 + 1) * 8 +
         size.dofs() * 8 * 20 + size.elements * (parameters * 8 + 200) + 5e7;
}

void hold(const PartOrder& order, const Budget& budget, const MeshSize& size,
          const std::function<MeshSize(double)>& resized) {
  const double bytes = bytes_of(size, order);
  if (bytes <= kCostMargin * budget.bytes())
    return;
  const double largest = std::max({size.box.x, size.box.y, size.box.z});
  double h = 1e-4 * largest;
  while (h < largest && bytes_of(resized(h), order) > budget.bytes())
    h *= 1.1;
  throw TooLarge(
      order.name() + format(": %.0f elements with %.0f unknowns", size.elements, size.dofs()) +
      " would take " + words_of_bytes(bytes) + ", expected at most " +
      words_of_bytes(budget.bytes()) +
      (order.memory_bytes > 0 ? " (--memory)" : ", half of what is free (--memory)") +
      (h < largest ? format(": take --h %.2g", h / order.unit) : "") +
      (order.petsc || !order.output.empty() ? "" : ", or --engine petsc over several processes"));
}

Mesh mesh_of_shape(const PartOrder& order, const Budget& budget, ProgressLine& progress) {
  const auto profile =
      order.profile.empty() ? std::vector<ProfilePoint>{} : read_profile(order.profile, order.unit);
  const auto plan_for = [&](double h) {
    MeshChoice choice = order.choice;
    choice.h = h;
    return plan_shape(order.body, order.dimensions, profile, choice);
  };
  const ShapePlan plan = plan_for(order.choice.h);
  hold(order, budget, plan.size, [&](double h) { return plan_for(h).size; });
  progress.stage("meshing", 0);
  return plan.make().mesh;
}

Mesh mesh_of_file(const PartOrder& order, const Budget& budget, ProgressLine& progress) {
  LoadChoice load = load_choice(order, progress);
  load.face_sets = order.needs_faces();
  if (load.face_sets)
    load.say = [&](const std::string& sentence) {
      if (!sentence.starts_with("face "))
        progress.say(sentence);
      else if (order.list_faces)
        std::puts(sentence.c_str());
    };
  load.elements_per_turn = kElementsPerTurn;
  load.size_for = [](double volume, double, double) {
    return std::cbrt(volume / (kTetrahedronShare * kUsualElements));
  };
  load.limits.memory_bytes = static_cast<std::uint64_t>(budget.bytes());
  load.foretold = [&](const MeshSize& size, const auto&) { // in the child
    hold(order, budget, size, [&](double h) { return resized_tetrahedra(size, h); });
  };
  return order.is_lift_arm() ? mesh_lift_arm(order.lift_arm(), load) : load_body(order.body, load);
}

/// Straightens the curved sides of tet10 whose scaled Jacobian is small, as long as that betters
/// them: such elements would stop the first move of a control point.
void straighten_flat(Mesh& mesh) {
  constexpr double kGoodEnough = .15;
  constexpr std::array<std::array<std::size_t, 2>, 6> kSides{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (int round = 0; round < 4; ++round) { // a node that moves may spoil a neighbour
    bool changed = false;
    for (const Element& e : mesh.elements) {
      if (e.shape != Shape::tet10 || scaled_jacobian(mesh, e) >= kGoodEnough)
        continue;
      const auto nodes = mesh.nodes_of(e);
      for (std::size_t side = 0; side < kSides.size(); ++side) {
        const auto at = [&](std::size_t k) -> Vector3& {
          return mesh.nodes[static_cast<std::size_t>(nodes[k])];
        };
        const Vector3 straight = .5 * (at(kSides[side][0]) + at(kSides[side][1]));
        changed |= !(at(4 + side) == straight);
        at(4 + side) = straight;
      }
    }
    if (!changed)
      return;
  }
}

/// Runs `select` with the option's words before its refusal.
template <class Select> auto selected(const std::string& words, Select&& select) {
  try {
    return select();
  } catch (const Refusal& refusal) {
    throw Refusal("--" + words + ": " + refusal.what());
  }
}

/// The direction that is most nearly in the plane of all faces: a round hole's axis. The smallest
/// eigenvector of the mean of n n' is the largest of 1 - n n', found by powers.
Vector3 axis_of_wall(const Mesh& mesh, std::span<const MeshFace> wall, const std::string& words) {
  std::array<Vector3, 3> m{};
  double whole = 0;
  for (const MeshFace& where : wall) {
    const Element& e = mesh.elements[static_cast<std::size_t>(where.element)];
    const Face& face = faces(e.shape)[static_cast<std::size_t>(where.face)];
    const auto at_node = [&](std::size_t c) {
      const auto local = static_cast<std::size_t>(face.node[c]);
      return mesh.nodes[static_cast<std::size_t>(mesh.nodes_of(e)[local])];
    };
    // The tangents at the middle; those of a curved triangle by its shape functions' derivatives.
    Vector3 along_r = at_node(1) - at_node(0), along_s = at_node(2) - at_node(0);
    if (face.corners == 4) {
      along_r = at_node(2) - at_node(0);
      along_s = at_node(3) - at_node(1);
    } else if (!is_linear(e.shape)) {
      along_r = (1. / 3) * along_r + (4. / 3) * (at_node(4) - at_node(5));
      along_s = (1. / 3) * along_s + (4. / 3) * (at_node(4) - at_node(3));
    }
    const Vector3 n = cross(along_r, along_s);
    const double area = length(n);
    whole += area;
    for (int i = 0; i < 3; ++i)
      m[static_cast<std::size_t>(i)] += (n[i] / std::max(area, 1e-300)) * n;
  }
  Vector3 axis{1, 1.1, 1.21};
  for (int k = 0; k < 200; ++k) {
    Vector3 next = whole * axis - Vector3{dot(m[0], axis), dot(m[1], axis), dot(m[2], axis)};
    axis = (1 / length(next)) * next;
  }
  const double along = dot(axis, {dot(m[0], axis), dot(m[1], axis), dot(m[2], axis)}) / whole;
  // Of squares of the eigenvalues' shares: 1/2 of a wall all around, 1 of a plane.
  const double flatness = (dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2])) / (whole * whole);
  if (!(along < .02 && flatness < .9))
    throw Refusal("--" + words +
                  ": expected the wall of a round hole or pin, whose faces turn "
                  "around one axis");
  return axis;
}

int nearest_skin_node(const Mesh& mesh, const Vector3& point) {
  const Surface skin = surface_of(mesh);
  return *std::min_element(skin.node.begin(), skin.node.end(), [&](int a, int b) {
    return length(mesh.nodes[static_cast<std::size_t>(a)] - point) <
           length(mesh.nodes[static_cast<std::size_t>(b)] - point);
  });
}

Load load_of(const LoadOrder& order, const Mesh& mesh) {
  using Kind = LoadOrder::Kind;
  if (order.kind == Kind::point)
    return PointForce{nearest_skin_node(mesh, order.point), order.value};
  const auto faces =
      selected(order.words, [&] { return select_faces(mesh, order.where.selection); });
  switch (order.kind) {
  case Kind::traction:
    return Traction{order.where.words, faces, order.value};
  case Kind::pressure:
    return Pressure{order.where.words, faces, order.value.x};
  case Kind::bolt: {
    Vector3 axis = axis_of_wall(mesh, faces, order.words);
    // Facets find the axis within a percent; a force that is no further from perpendicular is meant
    // to be perpendicular.
    const double size = length(order.value);
    const double along = size > 0 ? dot(axis, order.value) / size : 0;
    if (std::abs(along) < .02 && size > 0)
      axis = axis - (along / size) * order.value;
    return BoltLoad{order.where.words, faces, axis, order.value};
  }
  default:
    return TotalForce{order.where.words, faces, order.value};
  }
}

} // namespace

Mesh mesh_of(const PartOrder& order, ProgressLine& progress) {
  for (const std::string& path : {order.is_file ? order.body : std::string(), order.profile})
    if (!path.empty())
      check_readable(path);
  for (const auto& [region, name] : order.materials)
    (void)find_material(name);
  const Budget budget(order.memory_bytes);
  progress.stage("meshing", 0);
  Mesh mesh = order.is_file || order.is_lift_arm() ? mesh_of_file(order, budget, progress)
                                                   : mesh_of_shape(order, budget, progress);
  if (order.is_lift_arm() || order.is_file)
    straighten_flat(mesh);
  check(mesh);
  describe(mesh, progress, "stresses far too low");
  hold(order, budget, size_of(mesh),
       [&](double h) { return resized_tetrahedra(size_of(mesh), h); });
  if (const Parts parts = connected_parts(mesh); parts.count > 1 && !order.several_parts)
    throw Refusal("the mesh falls into " + std::to_string(parts.count) +
                  " parts that share no node, expected one (allow it with --multi)");
  return mesh;
}

StaticModel model_of(const PartOrder& order, const Mesh& mesh) {
  StaticModel model;
  model.materials = materials_of(order, mesh);
  for (const SupportOrder& s : order.supports) {
    if (s.stiffness_n_per_m == Vector3{})
      model.fixed.push_back(
          {s.words, selected(s.words, [&] { return select_nodes(mesh, s.where.selection); }),
           s.directions});
    else
      model.springs.push_back(
          {s.words, selected(s.words, [&] { return select_faces(mesh, s.where.selection); }),
           s.stiffness_n_per_m});
  }
  for (const LoadOrder& load : order.loads)
    model.loads.push_back(load_of(load, mesh));
  if (!(order.gravity == Vector3{}))
    model.loads.push_back(Gravity{order.gravity});
  return model;
}

std::vector<double> parameters_of(std::span<const Move> moves, const DesignSpace& space) {
  std::vector<double> values(space.parameters.size(), 0);
  for (const Move& move : moves)
    for (int axis = 0; axis < 3; ++axis) {
      const auto at = std::find_if(
          space.parameters.begin(), space.parameters.end(),
          [&](const ParameterRange& p) { return p.control == move.control && p.axis == axis; });
      if (at != space.parameters.end())
        values[static_cast<std::size_t>(at - space.parameters.begin())] += move.displacement[axis];
      else if (move.displacement[axis] != 0)
        throw Refusal(format("--move %d: control point %d may not move along %c (--controls, "
                             "--directions, or a face of the box that the body passes through)",
                             move.control, move.control, 'x' + axis));
    }
  return values;
}

} // namespace tactus::fem
