#include "programs/part_stress/part.hpp"

#include "fem/io/text.hpp"
#include "fem/modes/cost.hpp"
#include "programs/body/mpi_run.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace tactus::fem {
namespace {

constexpr double kDefaultElements =
    2200; ///< goal for a file; curved faces need two to four times as many
constexpr double kTetrahedronShare = .118; ///< volume of a regular tetrahedron of edge 1
/// Numbers of elements around curved faces with curved edges. The first resolves the peak at a hole
/// or fillet. The second, for a table, is smaller, because derivatives by every parameter and
/// solutions during a drag cost more.
constexpr int kElementsPerTurn = 12, kElementsPerTurnOfTable = 6;

/// Memory per pair of nodes, for K in this process during the export and for K, its levels and the
/// vectors in PETSc's processes (measured, docs/results/part_stress.md). Then the libraries' memory
/// per process.
constexpr double kPetscPairBytes = 900, kPetscProcessBytes = 7e7;

/// Bytes of the factor, the matrix and its graph, the mesh, and the sensitivities.
double bytes_of(const MeshSize& size, const PartOptions& options) {
  if (options.petsc) { // too many processes are refused later, when the mesh is known
    const double max_processes = size.nodes / static_cast<double>(kMinNodesPerProcess);
    return size.node_pairs * kPetscPairBytes +
           std::min<double>(options.ranks, max_processes) * kPetscProcessBytes + 5e7;
  }
  const double controls =
      options.design.points[0] * options.design.points[1] * options.design.points[2];
  const double parameters = options.output.empty() && options.moves.empty() ? 0 : 3 * controls;
  return predict_factor(size).memory_bytes + size.node_pairs * (9 + 1 + 1) * 8 +
         size.dofs() * 8 * 20 + size.elements * (parameters * 8 + 200) + 5e7;
}

void check_budget(const PartOptions& options, const Budget& budget, const MeshSize& size,
                  const std::function<MeshSize(double)>& resized) {
  const double bytes = bytes_of(size, options);
  if (bytes <= kCostMargin * budget.bytes())
    return;
  const double largest = std::max({size.box.x, size.box.y, size.box.z});
  double h = 1e-4 * largest;
  while (h < largest && bytes_of(resized(h), options) > budget.bytes())
    h *= 1.1;
  throw TooLarge(
      options.name() + format(": %.0f elements with %.0f unknowns", size.elements, size.dofs()) +
      " would take " + format_bytes(bytes) + ", expected at most " + format_bytes(budget.bytes()) +
      (options.memory_bytes > 0 ? " (--memory)" : ", half of the free memory (--memory)") +
      (h < largest ? format(": use --h %.2g", h / options.unit) : "") +
      (options.petsc || !options.output.empty() ? ""
                                                : ", or --engine petsc over several processes"));
}

Mesh mesh_of_shape(const PartOptions& options, const Budget& budget, ProgressLine& progress) {
  const auto profile = options.profile.empty() ? std::vector<ProfilePoint>{}
                                               : read_profile(options.profile, options.unit);
  const auto plan_for = [&](double h) {
    MeshChoice choice = options.choice;
    choice.h = h;
    return plan_shape(options.body, options.dimensions, profile, choice);
  };
  const ShapePlan plan = plan_for(options.choice.h);
  check_budget(options, budget, plan.size, [&](double h) { return plan_for(h).size; });
  progress.stage("meshing", 0);
  return plan.make().mesh;
}

Mesh mesh_of_file(const PartOptions& options, const Budget& budget, ProgressLine& progress) {
  LoadChoice load = load_choice(options, progress);
  load.face_sets = options.needs_faces();
  if (load.face_sets)
    load.notify = [&](const std::string& sentence) {
      if (!sentence.starts_with("face "))
        progress.notify(sentence);
      else if (options.list_faces)
        std::puts(sentence.c_str());
    };
  load.elements_per_turn = options.output.empty() ? kElementsPerTurn : kElementsPerTurnOfTable;
  if (options.output.empty()) {
    load.swept_elements_per_turn = 2 * kElementsPerTurn; // gives a hole's peak within .5 %
    load.swept_smallest = 1.0 / 12;
  }
  load.size_for = [](double volume, double, double) {
    return std::cbrt(volume / (kTetrahedronShare * kDefaultElements));
  };
  load.limits.memory_bytes = static_cast<std::uint64_t>(budget.bytes());
  load.on_prediction = [&](const MeshSize& size, const auto&) { // called in the child process
    check_budget(options, budget, size, [&](double h) { return resized_tetrahedra(size, h); });
  };
  return options.is_lift_arm() ? mesh_lift_arm(options.lift_arm(), load)
                               : load_body(options.body, load);
}

/// Straightens the curved sides of tet10 whose scaled Jacobian is small, if that improves them.
/// Such elements would stop the first move of a control point.
void straighten_flat(Mesh& mesh) {
  constexpr double kMinGoodJacobian = .15;
  constexpr std::array<std::array<std::size_t, 2>, 6> kSides{
      {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}}};
  for (int round = 0; round < 4; ++round) { // moving a node may worsen a neighbour
    bool changed = false;
    for (const Element& e : mesh.elements) {
      if (e.shape != Shape::tet10 || scaled_jacobian(mesh, e) >= kMinGoodJacobian)
        continue;
      const auto nodes = mesh.nodes_of(e);
      for (std::size_t side = 0; side < kSides.size(); ++side) {
        const auto at = [&](std::size_t k) -> Vec3& {
          return mesh.nodes[static_cast<std::size_t>(nodes[k])];
        };
        const Vec3 straight = .5 * (at(kSides[side][0]) + at(kSides[side][1]));
        changed |= !(at(4 + side) == straight);
        at(4 + side) = straight;
      }
    }
    if (!changed)
      return;
  }
}

/// Runs `select`; prefixes its refusal with the option's words.
template <class Select> auto selected(const std::string& words, Select&& select) {
  try {
    return select();
  } catch (const InputError& refusal) {
    throw InputError("--" + words + ": " + refusal.what());
  }
}

/// The axis of a round hole: the direction that is most nearly in the plane of all faces. It is the
/// eigenvector of the smallest eigenvalue of the mean of n n', hence of the largest of 1 - n n',
/// found by power iteration.
Vec3 axis_of_wall(const Mesh& mesh, std::span<const MeshFace> wall, const std::string& words) {
  std::array<Vec3, 3> m{};
  double whole = 0;
  for (const MeshFace& at_region : wall) {
    const Element& e = mesh.elements[static_cast<std::size_t>(at_region.element)];
    const Face& face = faces(e.shape)[static_cast<std::size_t>(at_region.face)];
    const auto at_node = [&](std::size_t c) {
      const auto local = static_cast<std::size_t>(face.node[c]);
      return mesh.nodes[static_cast<std::size_t>(mesh.nodes_of(e)[local])];
    };
    // The tangents at the centre. For a curved triangle they follow from the derivatives of its
    // shape functions.
    Vec3 along_r = at_node(1) - at_node(0), along_s = at_node(2) - at_node(0);
    if (face.corners == 4) {
      along_r = at_node(2) - at_node(0);
      along_s = at_node(3) - at_node(1);
    } else if (!is_linear(e.shape)) {
      along_r = (1. / 3) * along_r + (4. / 3) * (at_node(4) - at_node(5));
      along_s = (1. / 3) * along_s + (4. / 3) * (at_node(4) - at_node(3));
    }
    const Vec3 n = cross(along_r, along_s);
    const double area = length(n);
    whole += area;
    for (int i = 0; i < 3; ++i)
      m[static_cast<std::size_t>(i)] += (n[i] / std::max(area, 1e-300)) * n;
  }
  Vec3 axis{1, 1.1, 1.21};
  for (int k = 0; k < 200; ++k) {
    Vec3 next = whole * axis - Vec3{dot(m[0], axis), dot(m[1], axis), dot(m[2], axis)};
    axis = (1 / length(next)) * next;
  }
  const double along = dot(axis, {dot(m[0], axis), dot(m[1], axis), dot(m[2], axis)}) / whole;
  // Sum of squares of the relative eigenvalues: 1/2 for a cylinder wall, 1 for a plane.
  const double flatness = (dot(m[0], m[0]) + dot(m[1], m[1]) + dot(m[2], m[2])) / (whole * whole);
  if (!(along < .02 && flatness < .9))
    throw InputError("--" + words +
                     ": expected the wall of a round hole or pin, with faces all "
                     "around one axis");
  return axis;
}

int nearest_skin_node(const Mesh& mesh, const Vec3& point) {
  const Surface skin = surface_of(mesh);
  return *std::min_element(skin.node.begin(), skin.node.end(), [&](int a, int b) {
    return length(mesh.nodes[static_cast<std::size_t>(a)] - point) <
           length(mesh.nodes[static_cast<std::size_t>(b)] - point);
  });
}

Load load_of(const LoadOptions& options, const Mesh& mesh) {
  using Kind = LoadOptions::Kind;
  if (options.kind == Kind::point)
    return PointForce{nearest_skin_node(mesh, options.point), options.value};
  const auto faces =
      selected(options.words, [&] { return select_faces(mesh, options.at_region.selection); });
  switch (options.kind) {
  case Kind::traction:
    return Traction{options.at_region.words, faces, options.value};
  case Kind::pressure:
    return Pressure{options.at_region.words, faces, options.value.x};
  case Kind::bolt: {
    Vec3 axis = axis_of_wall(mesh, faces, options.words);
    // The axis found from facets is accurate to a percent, so a force within that of the
    // perpendicular counts as perpendicular.
    const double size = length(options.value);
    const double along = size > 0 ? dot(axis, options.value) / size : 0;
    if (std::abs(along) < .02 && size > 0)
      axis = axis - (along / size) * options.value;
    return BoltLoad{options.at_region.words, faces, axis, options.value};
  }
  default:
    return TotalForce{options.at_region.words, faces, options.value};
  }
}

/// Refuses a load whose nodal forces all act in fixed directions, because the supports carry all of
/// it.
void check_loads_act(const PartOptions& options, const Mesh& mesh, const StaticModel& model) {
  const std::vector<std::uint8_t> held = held_directions(mesh, model.fixed);
  for (std::size_t k = 0; k < options.loads.size(); ++k) {
    const auto force = load_vector(mesh, model.materials, std::span(&model.loads[k], 1));
    double whole = 0, moving = 0;
    for (std::size_t i = 0; i < force.size(); ++i) {
      whole += std::abs(force[i]);
      moving += held[i] ? 0 : std::abs(force[i]);
    }
    if (whole > 0 && moving < 1e-9 * whole)
      throw InputError("--" + options.loads[k].words +
                       " acts only on fixed nodes, so that it causes no stress: expected a region "
                       "that can move");
  }
}

} // namespace

Mesh mesh_of(const PartOptions& options, ProgressLine& progress) {
  for (const std::string& path : {options.is_file ? options.body : std::string(), options.profile})
    if (!path.empty())
      check_readable(path);
  for (const auto& [region, name] : options.materials)
    (void)find_material(name);
  const Budget budget(options.memory_bytes);
  progress.stage("meshing", 0);
  Mesh mesh = options.is_file || options.is_lift_arm() ? mesh_of_file(options, budget, progress)
                                                       : mesh_of_shape(options, budget, progress);
  if (options.is_lift_arm() || options.is_file)
    straighten_flat(mesh);
  check(mesh);
  describe(mesh, progress, "stresses far too low");
  warn_of_unusual_length(options, bounding_box(mesh.nodes).largest(),
                         [&](const std::string& sentence) { progress.notify(sentence); });
  check_budget(options, budget, size_of(mesh),
               [&](double h) { return resized_tetrahedra(size_of(mesh), h); });
  if (const Parts parts = connected_parts(mesh); parts.count > 1 && !options.several_parts)
    throw InputError("the mesh has " + std::to_string(parts.count) +
                     " parts that share no node, expected one (allow more with --multi)");
  return mesh;
}

StaticModel model_of(const PartOptions& options, const Mesh& mesh) {
  StaticModel model;
  model.materials = materials_of(options, mesh);
  for (const SupportOptions& s : options.supports) {
    if (s.stiffness_n_per_m == Vec3{})
      model.fixed.push_back(
          {s.words, selected(s.words, [&] { return select_nodes(mesh, s.at_region.selection); }),
           s.directions});
    else
      model.springs.push_back(
          {s.words, selected(s.words, [&] { return select_faces(mesh, s.at_region.selection); }),
           s.stiffness_n_per_m});
  }
  for (const LoadOptions& load : options.loads)
    model.loads.push_back(load_of(load, mesh));
  check_loads_act(options, mesh, model);
  if (!(options.gravity == Vec3{}))
    model.loads.emplace_back(Gravity{options.gravity});
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
        throw InputError(format("--move %d: control point %d is fixed along %c by --controls, "
                                "--directions or a face of the box that the body passes through",
                                move.control, move.control, 'x' + axis));
    }
  return values;
}

} // namespace tactus::fem
