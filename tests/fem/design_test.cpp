#include "design_bodies.hpp"
#include "fem/design/eigenvalue_sensitivity.hpp"
#include "fem/shapes/shapes.hpp"

#include <algorithm>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

/// A block with every kind of load and support, a third of it wood, in tet10 or hex20.
struct FullModel {
  Mesh mesh;
  StaticModel model;
  std::vector<DesignVelocity> velocities;

  explicit FullModel(bool tets) {
    set_solver_threads(1);
    const Vec3 size{.12, .05, .04};
    mesh = tets ? tetrahedral_box({6, 3, 2}, size, true)
                : block(even(0, size.x, 5), even(0, size.y, 2), even(0, size.z, 2));
    mesh.regions = {"steel", "wood"};
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      mesh.elements[e].region = e % 3 == 0;
    model.materials = {steel(), oblique_spruce()};
    model.fixed = {{"wall", select_nodes(mesh, plane(0, 0)), {true, true, true}, {0, 0, 1e-6}}};
    model.springs = {{"bed", select_faces(mesh, plane(2, 0)), {1e6, 2e6, 3e8}}};
    model.loads = {Gravity{{100, -2000, -3000}},
                   Pressure{"top", select_faces(mesh, plane(2, size.z)), 2e5},
                   Traction{"side", select_faces(mesh, plane(1, size.y)), {1e5, 2e5, 3e5}},
                   TotalForce{"end", select_faces(mesh, plane(0, size.x)), {100, 200, -300}},
                   PointForce{5, {10, 20, 30}}};
    const Lattice lattice{{{0, 0, 0}, size}, {4, 3, 3}, {2, 2, 2}};
    const std::vector<int> controls{lattice.control(2, 1, 2), lattice.control(3, 2, 0),
                                    lattice.control(1, 1, 1)};
    velocities = design_velocities(embed(mesh, lattice), free_parameters(controls));
  }
};

/// One parameter's part of an array [parameter][value].
template <class Values> std::vector<double> row(const Values& all, std::size_t k, std::size_t n) {
  return {all.begin() + static_cast<std::ptrdiff_t>(k * n),
          all.begin() + static_cast<std::ptrdiff_t>((k + 1) * n)};
}

std::vector<double> squared_frequencies(const Modes& modes) {
  std::vector<double> all;
  for (const double f : modes.frequency_hz)
    all.push_back(std::pow(2 * std::numbers::pi * f, 2));
  return all;
}

} // namespace

TEST_CASE("a Bernstein lattice has the binomial weights and moves its surface by 0.375") {
  const Mesh mesh = block(even(0, .2, 4), even(0, .02, 2), even(0, .02, 2));
  const ControlWeights weights = embed(mesh, cantilever_lattice());
  const auto bernstein = [](int degree, int at, double t) {
    double binomial = 1;
    for (int i = 0; i < at; ++i)
      binomial *= double(degree - i) / (i + 1);
    return binomial * std::pow(t, at) * std::pow(1 - t, degree - at);
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    for (std::size_t k = weights.start[n]; k < weights.start[n + 1]; ++k) {
      const int c = weights.control[k], i = c % 5, j = c / 5 % 3, l = c / 15;
      CHECK(weights.weight[k] == doctest::Approx(bernstein(4, i, mesh.nodes[n].x / .2) *
                                                 bernstein(2, j, mesh.nodes[n].y / .02) *
                                                 bernstein(2, l, mesh.nodes[n].z / .02))
                                     .epsilon(1e-12));
    }
  double fastest = 0;
  const auto velocities = top_row(mesh);
  for (const Vec3& v : velocities[0].velocity)
    fastest = std::max(fastest, v.z);
  CHECK(fastest == doctest::Approx(.375).epsilon(1e-12));
}

TEST_CASE("a lattice moved affinely moves its nodes affinely, whatever its degree") {
  // Greville abscissae: B-splines reproduce every point, and stretch, shear and turn too.
  const Mesh mesh = block({{0, .07, .3, 1}}, {{0, .4, 1}}, {{0, .1, 1}});
  const auto affine = [](const Vec3& p) {
    return Vec3{.3 * p.x - .2 * p.y + .1, .4 * p.z, .5 * p.x + .6 * p.y - .7 * p.z};
  };
  for (const std::array<int, 3>& degree : {std::array{1, 1, 1}, {2, 2, 1}, {3, 2, 2}, {4, 3, 2}}) {
    const ControlWeights weights = embed(mesh, {{{0, 0, 0}, {1, 1, 1}}, {5, 4, 3}, degree});
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      Vec3 moved, still;
      for (std::size_t k = weights.start[n]; k < weights.start[n + 1]; ++k) {
        const Vec3& c = weights.control_points[std::size_t(weights.control[k])];
        moved += weights.weight[k] * affine(c);
        still += weights.weight[k] * c;
      }
      CHECK(length(still - mesh.nodes[n]) < 1e-12);
      CHECK(length(moved - affine(mesh.nodes[n])) < 1e-12);
    }
  }
}

TEST_CASE("control points act near them alone, and nodes outside the box stay") {
  const Mesh mesh = block(even(0, 1, 10), even(0, 1, 1), even(0, 1, 1));
  const Lattice lattice{{{0, 0, 0}, {.8, 1, 1}}, {7, 2, 2}, {2, 1, 1}};
  const std::vector<ShapeParameter> one{{"one", {lattice.control(1, 0, 0)}, {1, 0, 0}}};
  const ControlWeights weights = embed(mesh, lattice);
  const auto velocities = design_velocities(weights, one);
  // Knots every 0.8 / 5: control point 1 of degree 2 acts up to the second inner knot.
  for (const int n : velocities[0].node)
    CHECK(mesh.nodes[std::size_t(n)].x < .32 + 1e-9);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    CHECK((weights.start[n + 1] > weights.start[n]) == (mesh.nodes[n].x < .8 + 1e-9));
}

TEST_CASE("weights of another kind of volume are taken, and checked") {
  const Mesh mesh = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  std::vector<double> weights;
  for (const Vec3& p : mesh.nodes)
    weights.insert(weights.end(), {1 - p.x, p.x});
  const std::vector<Vec3> ends{{0, 0, 0}, {1, 0, 0}};
  const std::vector<ShapeParameter> stretch{{"end", {1}, {1, 0, 0}}};
  const auto velocities = design_velocities(import_weights(mesh, ends, weights), stretch);
  const Mesh longer = moved_mesh(mesh, velocities[0], .5);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    CHECK(longer.nodes[n].x == doctest::Approx(1.5 * mesh.nodes[n].x));
  check_refused([&] { return import_weights(mesh, ends, std::span(weights).first(3)); },
                "expected 20 nodes times 2");
  for (const double wrong : {weights[5] + .1, double(NAN)}) {
    weights[5] = wrong;
    check_refused([&] { return import_weights(mesh, ends, weights); }, "weights of node 3 sum");
  }
}

TEST_CASE("bad lattices and parameters are one sentence") {
  const Mesh mesh = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  const auto lattice = [&](const Lattice& l, const char* words) {
    check_refused([&] { return embed(mesh, l); }, words);
  };
  lattice({{{0, 0, 0}, {1, 0, 1}}}, "no extent along y");
  lattice({{{0, 0, 0}, {1, 1, NAN}}}, "no extent along z");
  lattice({{{0, 0, 0}, {1, 1, 1}}, {1, 3, 3}, {1, 2, 2}}, "1 control points along x");
  lattice({{{0, 0, 0}, {1, 1, 1}}, {3, 3, 3}, {2, 3, 2}}, "degree 3 along y");
  lattice({{{0, 0, 0}, {1, 1, 1}}, {3, 3, 3}, {2, 2, 0}}, "degree 0 along z");
  lattice({{{5, 5, 5}, {6, 6, 6}}}, "no node of the mesh");
  const ControlWeights weights = embed(mesh, {{{0, 0, 0}, {1, 1, 1}}});
  const auto parameter = [&](const ShapeParameter& p, const char* words) {
    check_refused([&] { return design_velocities(weights, std::span(&p, 1)); }, words);
  };
  parameter({"a", {27}, {1, 0, 0}}, "control point 27, expected 0 to 26");
  parameter({"b", {0}, {}}, "parameter b moves no node");
  parameter({"c", {}, {1, 0, 0}}, "parameter c moves no node");
}

TEST_CASE("the scaled Jacobian is one in ideal elements and known in sheared ones") {
  Mesh cube = block(even(0, 2, 1), even(0, 2, 1), even(0, 2, 1));
  CHECK(scaled_jacobian(cube, cube.elements[0]) == doctest::Approx(1));
  for (Vec3& p : cube.nodes)
    p.x += .75 * p.z;
  CHECK(scaled_jacobian(cube, cube.elements[0]) == doctest::Approx(1 / std::sqrt(1 + .75 * .75)));
  Mesh regular;
  regular.nodes = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  regular.add(Shape::tet4, std::array{0, 1, 2, 3});
  CHECK(scaled_jacobian(regular, regular.elements[0]) == doctest::Approx(1));
  std::swap(regular.nodes[0], regular.nodes[1]);
  CHECK(scaled_jacobian(regular, regular.elements[0]) == doctest::Approx(-1));
  // A corner tetrahedron: sqrt 2 / (1 * sqrt 2 * sqrt 2).
  const Mesh corner = tetrahedral_block(1, true);
  for (const Element& e : corner.elements)
    CHECK(scaled_jacobian(corner, e) < .75);
  const Mesh disk = make_shape("disk", {{"diameter", .1}, {"thickness", .02}}, {}, {.02});
  for (const Element& e : disk.elements) {
    CHECK(scaled_jacobian(disk, e) > .3);
    CHECK(scaled_jacobian(disk, e) <= 1 + 1e-9);
  }
}

TEST_CASE("a step stops where the mesh would turn inside out") {
  const Mesh cube = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 2));
  const auto step = [](const Mesh& mesh, const auto& motion) {
    std::vector<Vec3> target = mesh.nodes;
    for (Vec3& p : target)
      p += motion(p);
    return valid_step(mesh, target);
  };
  // 1 / sqrt(1 + s^2) is 0.05 at a shear of s = 19.97.
  const ValidStep sheared = step(cube, [](const Vec3& p) { return Vec3{40 * p.z, 0, 0}; });
  CHECK(sheared.fraction == doctest::Approx(19.975 / 40).epsilon(2e-3));
  CHECK(sheared.scaled_jacobian >= .05);
  // The middle nodes pass the top.
  const ValidStep passed = step(cube, [](const Vec3& p) {
    return Vec3{0, 0, p.z == .5 ? 1. : 0.};
  });
  CHECK(passed.fraction > 0);
  CHECK(passed.fraction < .5);
  // Flattened evenly, to a twentieth of the volume.
  CHECK(step(cube, [](const Vec3& p) {
          return Vec3{0, 0, -2 * p.z};
        }).fraction == doctest::Approx(.475).epsilon(2e-3));
  const ValidStep shifted = step(cube, [](const Vec3&) { return Vec3{.1, 0, 0}; });
  CHECK(shifted.fraction == 1);
  CHECK(shifted.scaled_jacobian == doctest::Approx(1));
  // One corner pushed inwards by t along the diagonal: there alone, det = 1 - 3 t over edges of
  // sqrt((1 - t)^2 + 2 t^2), which is 0.05 at t = 0.3242.
  const Mesh one = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  CHECK(step(one, [](const Vec3& p) {
          return -.5 * p.x * p.y * p.z * Vec3{1, 1, 1};
        }).fraction == doctest::Approx(.3242 / .5).epsilon(3e-3));
  // Elements that are bad to begin with may move, but not get worse.
  Mesh bad = cube;
  for (Vec3& p : bad.nodes)
    p.x += 30 * p.z;
  CHECK(step(bad, [](const Vec3& p) { return Vec3{-p.z, 0, 0}; }).fraction == 1);
  CHECK(step(bad, [](const Vec3& p) { return Vec3{p.z, 0, 0}; }).fraction < 2e-3);
  check_refused([&] { return valid_step(cube, std::span(cube.nodes).first(3)); }, "has 3 nodes");
}

TEST_CASE("derivatives of displacement and stress, and of scalars by one adjoint solve, are those "
          "of a re-solve") {
  // Central differences of full solves, truncation (1e-4)^2. The bound of the specification is
  // 1e-4; S is kept in single precision.
  for (const bool tets : {true, false}) {
    FullModel part(tets);
    StaticAnalysis analysis = solve_static(part.mesh, part.model);
    const auto du = displacement_sensitivity(part.mesh, part.model, analysis, part.velocities);
    const auto ds = stress_sensitivity(part.mesh, part.model, analysis, part.velocities);
    std::vector<StressScalar> scalars;
    std::vector<Gradient> gradients;
    for (const StressMeasure measure : {StressMeasure::von_mises, StressMeasure::max_shear})
      for (const auto kind : {StressScalar::Kind::mean, StressScalar::Kind::volume_mean,
                              StressScalar::Kind::p_norm}) {
        scalars.push_back({kind, measure, 6});
        gradients.push_back(
            stress_scalar(part.mesh, part.model, analysis, scalars.back(), part.velocities));
      }
    const double h = 2e-6;
    for (const std::size_t k : {0U, 4U, 8U}) { // x of one control point, y and z of others
      std::array<std::vector<double>, 2> u, mises, shear, values;
      for (const std::size_t side : {0U, 1U}) {
        const Mesh mesh = moved_mesh(part.mesh, part.velocities[k], side == 0 ? h : -h);
        StaticAnalysis own = solve_static(mesh, part.model);
        u[side] = own.solution.displacement;
        const auto stress = element_stress(mesh, part.model.materials, u[side]);
        mises[side] = equivalent_stress(stress, StressMeasure::von_mises);
        shear[side] = equivalent_stress(stress, StressMeasure::max_shear);
        for (const StressScalar& scalar : scalars)
          values[side].push_back(stress_scalar(mesh, part.model, own, scalar, {}).value);
      }
      const auto agrees = [&](const std::vector<double>& derivative, const auto& sides) {
        const auto slope = central_difference(sides[0], sides[1], h);
        CHECK(relative_difference(derivative, slope) < 2e-6);
      };
      const std::size_t elements = part.mesh.elements.size();
      agrees(row(du, k, part.mesh.dofs()), u);
      agrees(row(ds.von_mises, k, elements), mises);
      agrees(row(ds.max_shear, k, elements), shear);
      const auto slope = central_difference(values[0], values[1], h);
      for (std::size_t s = 0; s < scalars.size(); ++s) {
        const auto& all = gradients[s].by_parameter;
        const auto [low, high] = std::minmax_element(all.begin(), all.end());
        CHECK(std::abs(all[k] - slope[s]) < 1e-6 * std::max(*high, -*low));
      }
    }
  }
}

TEST_CASE("a bolt's pressure follows its hole as it grows") {
  // The wall grows with its radius: the bolt's force stays, its pressure falls.
  set_solver_threads(1);
  const Mesh mesh = make_shape(
      "ring", {{"outer_diameter", .06}, {"inner_diameter", .02}, {"thickness", .005}}, {}, {.01});
  const auto wall = [&](double r) {
    return select_faces(mesh, {OnCylinder{{0, 0, -1}, {0, 0, 1}, r, false}, 1e-6});
  };
  StaticModel model;
  model.materials = {steel()};
  model.fixed = {{"rim", nodes_of_faces(mesh, wall(.03)), {true, true, true}, {}}};
  model.loads = {BoltLoad{"pin", wall(.01), {0, 0, 1}, {3000, 1000, 0}}};
  DesignVelocity wider{"radius", {}, {}};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vec3 flat{mesh.nodes[n].x, mesh.nodes[n].y, 0};
    wider.node.push_back(static_cast<int>(n));
    wider.velocity.push_back((.03 - length(flat)) / .02 / length(flat) * flat);
  }
  StaticAnalysis analysis = solve_static(mesh, model);
  const auto du = displacement_sensitivity(mesh, model, analysis, std::span(&wider, 1));
  const double h = 1e-6;
  const auto moved = [&](double by) {
    return solve_static(moved_mesh(mesh, wider, by), model).solution.displacement;
  };
  CHECK(relative_difference(du, central_difference(moved(h), moved(-h), h)) < 1e-4);
}

TEST_CASE("scalars have their definitions' values") {
  // A column pressed evenly: every mean of the stress is that stress.
  const Mesh mesh = block(even(0, .1, 2), {{0, .03, .1}}, even(0, .1, 2));
  StaticModel model;
  model.materials = {steel(0)};
  model.fixed = {{"foot", select_nodes(mesh, plane(2, 0)), {true, true, true}, {}}};
  model.loads = {Pressure{"top", select_faces(mesh, plane(2, .1)), 5e6}};
  StaticAnalysis analysis = solve_static(mesh, model);
  const auto scalar = [&](const StressScalar& of) {
    return stress_scalar(mesh, model, analysis, of, {}).value;
  };
  for (const auto kind :
       {StressScalar::Kind::mean, StressScalar::Kind::volume_mean, StressScalar::Kind::p_norm}) {
    CHECK(scalar({kind, StressMeasure::von_mises, 8}) == doctest::Approx(5e6).epsilon(1e-9));
    CHECK(scalar({kind, StressMeasure::max_shear, 8}) == doctest::Approx(2.5e6).epsilon(1e-9));
  }
  check_refused(
      [&] {
        return scalar({StressScalar::Kind::p_norm, StressMeasure::von_mises, 0});
      },
      "p-norm");
  // A bent beam: the p-norm rises with p towards the largest.
  const Cantilever beam(block(even(0, .2, 10), even(0, .02, 1), even(0, .02, 2)), 0);
  StaticAnalysis bent = beam.solve();
  const auto s = solved_von_mises(beam.mesh, beam.model);
  const double largest = *std::max_element(s.begin(), s.end());
  double below = 0;
  for (const double p : {1., 4., 20., 400.}) {
    const StressScalar norm_of{StressScalar::Kind::p_norm, StressMeasure::von_mises, p};
    const double norm = stress_scalar(beam.mesh, beam.model, bent, norm_of, {}).value;
    CHECK(norm > below);
    CHECK(norm < largest * (1 + 1e-9));
    below = norm;
  }
  CHECK(below > .98 * largest);
}

TEST_CASE("the volume's gradient is that of the moved mesh") {
  const FullModel part(true);
  const Gradient gradient = volume_gradient(part.mesh, part.velocities);
  CHECK(gradient.value == doctest::Approx(.12 * .05 * .04).epsilon(1e-12));
  for (std::size_t k = 0; k < part.velocities.size(); ++k) {
    const double h = 1e-5;
    const double slope = (volume(moved_mesh(part.mesh, part.velocities[k], h)) -
                          volume(moved_mesh(part.mesh, part.velocities[k], -h))) /
                         (2 * h);
    CHECK(std::abs(gradient.by_parameter[k] - slope) < 1e-8 * .05 * .04);
  }
}

namespace {

/// A steel bar of 100 mm whose control points are moved, on springs or free.
struct Bar {
  Mesh mesh;
  Lattice lattice;
  std::vector<Material> materials{steel()};
  std::vector<SpringPatch> springs;
  std::vector<DesignVelocity> velocities;

  Bar(double width, const std::array<int, 3>& counts, const std::array<int, 3>& degrees,
      const auto& parameters)
      : mesh(block(even(0, .1, 8), even(0, width, 2), even(0, .01, 2))), lattice{{{0, 0, 0},
                                                                                  {.1, width, .01}},
                                                                                 counts,
                                                                                 degrees},
        velocities(design_velocities(embed(mesh, lattice), parameters(lattice))) {
    set_solver_threads(1);
  }
  [[nodiscard]] Modes modes(const Mesh& own, std::size_t count) const {
    Matrices matrices = assemble(own, materials, {});
    add_springs(own, springs, matrices);
    ModeSettings settings;
    settings.count = count;
    return find_modes(own, materials, matrices, settings);
  }
  [[nodiscard]] std::vector<double> slopes(const Modes& given, std::size_t wanted) const {
    return eigenvalue_sensitivity(mesh, materials, springs,
                                  {given.frequency_hz, given.shapes, wanted}, velocities);
  }
  /// omega^2 of `count` modes of the bar with one parameter moved.
  [[nodiscard]] std::vector<double> moved(std::size_t parameter, double by,
                                          std::size_t count) const {
    return squared_frequencies(modes(moved_mesh(mesh, velocities[parameter], by), count));
  }
};

ShapeParameter thicker(const Lattice& l) {
  return {"thicker", {l.control(1, 0, 1), l.control(1, 1, 1)}, {0, 0, 1}};
}

} // namespace

TEST_CASE("derivatives of eigenvalues are those of a re-solve, pairs too") {
  Bar bar(.012, {4, 2, 2}, {3, 1, 1}, [](const Lattice& l) {
    return std::vector<ShapeParameter>{
        thicker(l),
        {"longer",
         {l.control(3, 0, 0), l.control(3, 1, 0), l.control(3, 0, 1), l.control(3, 1, 1)},
         {1, 0, 0}}};
  });
  bar.springs = {{"bed", select_faces(bar.mesh, plane(1, 0)), {1e6, 2e6, 3e6}}};
  const Modes modes = bar.modes(bar.mesh, 5);
  const auto slopes = bar.slopes(modes, 4);
  const double h = 1e-6;
  for (std::size_t p = 0; p < 2; ++p) {
    const auto slope = central_difference(bar.moved(p, h, 5), bar.moved(p, -h, 5), h);
    for (std::size_t k = 0; k < 4; ++k)
      CHECK(slopes[4 * p + k] == doctest::Approx(slope[k]).epsilon(2e-5));
  }
  check_refused([&] { return bar.slopes(modes, 5); }, "beyond the 5 modes given");
  check_refused([&] { return bar.slopes(modes, 6); }, "derivatives of 6 modes");
}

TEST_CASE("a square bar's pair of bending modes parts as its two thicknesses do") {
  const Bar bar(.01, {3, 2, 2}, {2, 1, 1},
                [](const Lattice& l) { return std::vector<ShapeParameter>{thicker(l)}; });
  Modes modes = bar.modes(bar.mesh, 6);
  CHECK(modes.frequency_hz[1] - modes.frequency_hz[0] < 1e-5 * modes.frequency_hz[0]);
  const auto slopes = bar.slopes(modes, 2);
  // The sides of the difference are two branches that cross at the square: ascending above it,
  // exchanged below.
  const double h = 2e-6;
  const auto up = bar.moved(0, h, 6), down = bar.moved(0, -h, 6);
  CHECK(slopes[0] == doctest::Approx((up[0] - down[1]) / (2 * h)).epsilon(1e-4));
  CHECK(slopes[1] == doctest::Approx((up[1] - down[0]) / (2 * h)).epsilon(1e-4));
  CHECK(slopes[1] > 3 * std::abs(slopes[0])); // bending across the thicker side stiffens
  // Asked for half a pair, with the other half given but not what follows.
  modes.frequency_hz.resize(2);
  modes.shapes.resize(2 * bar.mesh.dofs());
  check_refused([&] { return bar.slopes(modes, 1); }, "may belong to a group");
}
