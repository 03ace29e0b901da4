#include "design_bodies.hpp"
#include "fem/design/eigenvalue_sensitivity.hpp"
#include "fem/shapes/shapes.hpp"

#include <algorithm>

using namespace tactus::fem;

namespace {

/// A block with every kind of load and support, half of it wood, in tet10 or hex20.
struct FullModel {
  Mesh mesh;
  StaticModel model;
  std::vector<DesignVelocity> velocities;

  explicit FullModel(bool tets) {
    set_solver_threads(1);
    const Vector3 size{.12, .05, .04};
    mesh = tets ? tetrahedral_box({6, 3, 2}, size, true)
                : block(even(0, size.x, 5), even(0, size.y, 2), even(0, size.z, 2));
    mesh.regions = {"steel", "wood"};
    for (std::size_t e = 0; e < mesh.elements.size(); ++e)
      mesh.elements[e].region = e % 3 == 0;
    Material wood;
    wood.density = 700;
    wood.young_pa = {11e9, 0.8e9, 0.45e9};
    wood.poisson = {0.44, 0.38, 0.36};
    wood.shear_pa = {0.04e9, 0.6e9, 0.75e9};
    wood.axis_1 = {1, 1, 0};
    wood.axis_2 = {-1, 1, 0};
    model.materials = {steel(), wood};
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

std::vector<double> doubles(std::span<const float> values) {
  return {values.begin(), values.end()};
}

} // namespace

TEST_CASE("a Bernstein lattice has the binomial weights and moves its surface by 0.375") {
  const Mesh mesh = block(even(0, .2, 4), even(0, .02, 2), even(0, .02, 2));
  const Lattice lattice = cantilever_lattice();
  const ControlWeights weights = embed(mesh, lattice);
  const auto binomial = [](int n, int k) {
    double b = 1;
    for (int i = 0; i < k; ++i)
      b *= double(n - i) / (i + 1);
    return b;
  };
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    double sum = 0;
    for (std::size_t k = weights.start[n]; k < weights.start[n + 1]; ++k) {
      const int c = weights.control[k], i = c % 5, j = c / 5 % 3, l = c / 15;
      const auto bernstein = [&](int degree, int at, double t) {
        return binomial(degree, at) * std::pow(t, at) * std::pow(1 - t, degree - at);
      };
      CHECK(weights.weight[k] == doctest::Approx(bernstein(4, i, mesh.nodes[n].x / .2) *
                                                 bernstein(2, j, mesh.nodes[n].y / .02) *
                                                 bernstein(2, l, mesh.nodes[n].z / .02))
                                     .epsilon(1e-12));
      sum += weights.weight[k];
    }
    CHECK(sum == doctest::Approx(1).epsilon(1e-12));
  }
  const auto velocity = top_row(mesh);
  double fastest = 0;
  for (const Vector3& v : velocity[0].velocity)
    fastest = std::max(fastest, v.z);
  CHECK(fastest == doctest::Approx(.375).epsilon(1e-12));
}

TEST_CASE("a lattice moved affinely moves its nodes affinely, whatever its degree") {
  // Greville abscissae: B-splines reproduce every point, and stretch, shear and turn too.
  const Mesh mesh = block({{0, .07, .3, 1}}, {{0, .4, 1}}, {{0, .1, 1}});
  for (const std::array<int, 3>& degree : {std::array{1, 1, 1}, {2, 2, 1}, {3, 2, 2}, {4, 3, 2}}) {
    const Lattice lattice{{{0, 0, 0}, {1, 1, 1}}, {5, 4, 3}, degree};
    const ControlWeights weights = embed(mesh, lattice);
    const auto affine = [](const Vector3& p) {
      return Vector3{.3 * p.x - .2 * p.y + .1, .4 * p.z, .5 * p.x + .6 * p.y - .7 * p.z};
    };
    for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
      Vector3 moved, still;
      for (std::size_t k = weights.start[n]; k < weights.start[n + 1]; ++k) {
        const Vector3& c = weights.control_points[std::size_t(weights.control[k])];
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
  const auto velocities = design_velocities(embed(mesh, lattice), one);
  // Knots every 0.8 / 5: control point 1 of degree 2 acts up to the second inner knot.
  for (const int n : velocities[0].node)
    CHECK(mesh.nodes[std::size_t(n)].x < .32 + 1e-9);
  const ControlWeights weights = embed(mesh, lattice);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    CHECK((weights.start[n + 1] > weights.start[n]) == (mesh.nodes[n].x < .8 + 1e-9));
}

TEST_CASE("weights of another kind of volume are taken, and checked") {
  const Mesh mesh = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  std::vector<double> weights(2 * mesh.nodes.size());
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    weights[2 * n] = 1 - mesh.nodes[n].x;
    weights[2 * n + 1] = mesh.nodes[n].x;
  }
  const std::vector<Vector3> ends{{0, 0, 0}, {1, 0, 0}};
  const std::vector<ShapeParameter> stretch{{"end", {1}, {1, 0, 0}}};
  const auto velocities = design_velocities(import_weights(mesh, ends, weights), stretch);
  const Mesh longer = moved_mesh(mesh, velocities[0], .5);
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    CHECK(longer.nodes[n].x == doctest::Approx(1.5 * mesh.nodes[n].x));
  CHECK(mentions(refusal([&] { (void)import_weights(mesh, ends, std::span(weights).first(3)); }),
                 "expected 20 nodes times 2"));
  weights[5] += .1;
  CHECK(mentions(refusal([&] { (void)import_weights(mesh, ends, weights); }),
                 "weights of node 3 sum"));
  weights[5] = NAN;
  CHECK(mentions(refusal([&] { (void)import_weights(mesh, ends, weights); }),
                 "weights of node 3 sum"));
}

TEST_CASE("bad lattices and parameters are one sentence") {
  const Mesh mesh = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  const auto error_text = [&](const Lattice& l) { return refusal([&] { (void)embed(mesh, l); }); };
  CHECK(mentions(error_text({{{0, 0, 0}, {1, 0, 1}}}), "no extent along y"));
  CHECK(mentions(error_text({{{0, 0, 0}, {1, 1, NAN}}}), "no extent along z"));
  CHECK(mentions(error_text({{{0, 0, 0}, {1, 1, 1}}, {1, 3, 3}, {1, 2, 2}}),
                 "1 control points along x"));
  CHECK(mentions(error_text({{{0, 0, 0}, {1, 1, 1}}, {3, 3, 3}, {2, 3, 2}}), "degree 3 along y"));
  CHECK(mentions(error_text({{{0, 0, 0}, {1, 1, 1}}, {3, 3, 3}, {2, 2, 0}}), "degree 0 along z"));
  CHECK(mentions(error_text({{{5, 5, 5}, {6, 6, 6}}}), "no node of the mesh"));
  const ControlWeights weights = embed(mesh, {{{0, 0, 0}, {1, 1, 1}}});
  const auto velocities = [&](const ShapeParameter& p) {
    return refusal([&] { (void)design_velocities(weights, std::span(&p, 1)); });
  };
  CHECK(mentions(velocities({"a", {27}, {1, 0, 0}}), "control point 27, expected 0 to 26"));
  CHECK(mentions(velocities({"b", {0}, {}}), "parameter b moves no node"));
  CHECK(mentions(velocities({"c", {}, {1, 0, 0}}), "parameter c moves no node"));
}

TEST_CASE("the scaled Jacobian is one in ideal elements and known in sheared ones") {
  Mesh cube = block(even(0, 2, 1), even(0, 2, 1), even(0, 2, 1));
  CHECK(scaled_jacobian(cube, cube.elements[0]) == doctest::Approx(1));
  for (Vector3& p : cube.nodes)
    p.x += .75 * p.z;
  CHECK(scaled_jacobian(cube, cube.elements[0]) == doctest::Approx(1 / std::sqrt(1 + .75 * .75)));
  Mesh regular;
  regular.nodes = {{1, 1, 1}, {-1, 1, -1}, {1, -1, -1}, {-1, -1, 1}};
  const std::array<int, 4> order{0, 1, 2, 3};
  regular.add(Shape::tet4, order);
  CHECK(scaled_jacobian(regular, regular.elements[0]) == doctest::Approx(1));
  std::swap(regular.nodes[0], regular.nodes[1]);
  CHECK(scaled_jacobian(regular, regular.elements[0]) == doctest::Approx(-1));
  // A corner tetrahedron: sqrt 2 / (1 * sqrt 2 * sqrt 2).
  Mesh corner = tetrahedral_block(1, true);
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
  auto target = cube.nodes;
  for (Vector3& p : target)
    p.x += 40 * p.z; // 1 / sqrt(1 + s^2) is 0.05 at s = 19.97
  ValidStep step = valid_step(cube, target);
  CHECK(step.fraction == doctest::Approx(19.975 / 40).epsilon(2e-3));
  CHECK(step.scaled_jacobian >= .05);
  for (std::size_t n = 0; n < target.size(); ++n)
    target[n] = cube.nodes[n] + Vector3{0, 0, cube.nodes[n].z == .5 ? 1.0 : 0.0};
  step = valid_step(cube, target); // the middle nodes pass the top
  CHECK(step.fraction > 0);
  CHECK(step.fraction < .5);
  for (std::size_t n = 0; n < target.size(); ++n)
    target[n] = {cube.nodes[n].x, cube.nodes[n].y, -cube.nodes[n].z};
  CHECK(valid_step(cube, target).fraction ==
        doctest::Approx(.475).epsilon(2e-3)); // flattened evenly
  for (std::size_t n = 0; n < target.size(); ++n)
    target[n] = cube.nodes[n] + Vector3{.1, 0, 0};
  step = valid_step(cube, target);
  CHECK(step.fraction == 1);
  CHECK(step.scaled_jacobian == doctest::Approx(1));
  // One corner pushed inwards by t along the diagonal: there alone, det = 1 - 3 t over edges of
  // sqrt((1 - t)^2 + 2 t^2), which is 0.05 at t = 0.3242.
  const Mesh one = block(even(0, 1, 1), even(0, 1, 1), even(0, 1, 1));
  auto pushed = one.nodes;
  for (Vector3& p : pushed) {
    const double weight = p.x * p.y * p.z;
    p += -.5 * weight * Vector3{1, 1, 1};
  }
  CHECK(valid_step(one, pushed).fraction == doctest::Approx(.3242 / .5).epsilon(3e-3));
  // Elements that are bad to begin with may move, but not get worse.
  Mesh bad = cube;
  for (Vector3& p : bad.nodes)
    p.x += 30 * p.z;
  auto better = bad.nodes, worse = bad.nodes;
  for (std::size_t n = 0; n < bad.nodes.size(); ++n) {
    better[n].x -= bad.nodes[n].z;
    worse[n].x += bad.nodes[n].z;
  }
  CHECK(valid_step(bad, better).fraction == 1);
  CHECK(valid_step(bad, worse).fraction < 2e-3);
  CHECK(mentions(refusal([&] { (void)valid_step(cube, std::span(target).first(3)); }),
                 "has 3 nodes"));
}

TEST_CASE("derivatives of displacement and stress are those of a re-solve") {
  // Central differences of full solves, truncation (1e-4)^2. The bound of the specification is
  // 1e-4; S is kept in single precision.
  for (const bool tets : {true, false}) {
    FullModel part(tets);
    StaticAnalysis analysis = solve_static(part.mesh, part.model);
    const auto du = displacement_sensitivity(part.mesh, part.model, analysis, part.velocities);
    const auto ds = stress_sensitivity(part.mesh, part.model, analysis, part.velocities);
    const std::size_t n = part.mesh.dofs(), elements = part.mesh.elements.size();
    for (std::size_t k = 0; k < part.velocities.size(); ++k) {
      const double h = 2e-6;
      std::array<std::vector<double>, 2> u, mises, shear;
      for (const std::size_t side : {0U, 1U}) {
        const Mesh mesh = moved_mesh(part.mesh, part.velocities[k], side == 0 ? h : -h);
        u[side] = solve_static(mesh, part.model).solution.displacement;
        const auto stress = element_stress(mesh, part.model.materials, u[side]);
        mises[side] = equivalent_stress(stress, StressMeasure::von_mises);
        shear[side] = equivalent_stress(stress, StressMeasure::max_shear);
      }
      for (auto* both : {&u, &mises, &shear})
        for (std::size_t i = 0; i < (*both)[0].size(); ++i)
          (*both)[0][i] = ((*both)[0][i] - (*both)[1][i]) / (2 * h);
      CHECK(relative_difference(std::span(du).subspan(k * n, n), u[0]) < 2e-6);
      CHECK(relative_difference(doubles(std::span(ds.von_mises).subspan(k * elements, elements)),
                                mises[0]) < 2e-6);
      CHECK(relative_difference(doubles(std::span(ds.max_shear).subspan(k * elements, elements)),
                                shear[0]) < 2e-6);
    }
  }
}

TEST_CASE("the cantilever's sensitivity is right to 1e-4 and better") {
  const Cantilever beam(Cantilever::tetrahedra(), .3);
  const auto row = top_row(beam.mesh);
  StaticAnalysis analysis = solve_static(beam.mesh, beam.model);
  const auto s = stress_sensitivity(beam.mesh, beam.model, analysis, row);
  std::array<std::vector<double>, 2> mises;
  const double h = 1e-4 * beam.kHeight;
  for (const std::size_t side : {0U, 1U}) {
    const Mesh mesh = moved_mesh(beam.mesh, row[0], side == 0 ? h : -h);
    mises[side] =
        equivalent_stress(element_stress(mesh, beam.model.materials,
                                         solve_static(mesh, beam.model).solution.displacement),
                          StressMeasure::von_mises);
  }
  for (std::size_t e = 0; e < mises[0].size(); ++e)
    mises[0][e] = (mises[0][e] - mises[1][e]) / (2 * h);
  const double difference = relative_difference(doubles(s.von_mises), mises[0]);
  MESSAGE("relative L2 difference " << difference);
  CHECK(difference < 2e-6);
}

TEST_CASE("one adjoint solve gives the gradient of a scalar by all parameters") {
  for (const bool tets : {true, false}) {
    FullModel part(tets);
    StaticAnalysis analysis = solve_static(part.mesh, part.model);
    for (const StressMeasure measure : {StressMeasure::von_mises, StressMeasure::max_shear})
      for (const auto kind : {StressScalar::Kind::mean, StressScalar::Kind::volume_mean,
                              StressScalar::Kind::p_norm}) {
        const StressScalar scalar{kind, measure, 6};
        const auto value = [&](const Mesh& mesh) {
          StaticAnalysis own = solve_static(mesh, part.model);
          return stress_scalar(mesh, part.model, own, scalar, {}).value;
        };
        const Gradient gradient =
            stress_scalar(part.mesh, part.model, analysis, scalar, part.velocities);
        double size = 0;
        for (const double g : gradient.by_parameter)
          size = std::max(size, std::abs(g));
        for (const std::size_t k : {0U, 4U, 8U}) {
          const double h = 2e-6;
          const double slope = (value(moved_mesh(part.mesh, part.velocities[k], h)) -
                                value(moved_mesh(part.mesh, part.velocities[k], -h))) /
                               (2 * h);
          CHECK(std::abs(gradient.by_parameter[k] - slope) < 1e-6 * size);
        }
      }
  }
}

TEST_CASE("a bolt's pressure follows its hole as it grows") {
  // The wall grows with its radius: the bolt's force stays, its pressure falls.
  set_solver_threads(1);
  const Mesh mesh = make_shape(
      "ring", {{"outer_diameter", .06}, {"inner_diameter", .02}, {"thickness", .005}}, {}, {.006});
  const auto wall = [&](double r) {
    return select_faces(mesh, {OnCylinder{{0, 0, -1}, {0, 0, 1}, r, false}, 1e-6});
  };
  StaticModel model;
  model.materials = {steel()};
  model.fixed = {{"rim", nodes_of_faces(mesh, wall(.03)), {true, true, true}, {}}};
  model.loads = {BoltLoad{"pin", wall(.01), {0, 0, 1}, {3000, 1000, 0}}};
  DesignVelocity wider{"radius", {}, {}};
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n) {
    const Vector3 flat{mesh.nodes[n].x, mesh.nodes[n].y, 0};
    wider.node.push_back(static_cast<int>(n));
    wider.velocity.push_back((.03 - length(flat)) / .02 / length(flat) * flat);
  }
  StaticAnalysis analysis = solve_static(mesh, model);
  const auto du = displacement_sensitivity(mesh, model, analysis, std::span(&wider, 1));
  const double h = 1e-6;
  auto up = solve_static(moved_mesh(mesh, wider, h), model).solution.displacement;
  const auto down = solve_static(moved_mesh(mesh, wider, -h), model).solution.displacement;
  for (std::size_t i = 0; i < up.size(); ++i)
    up[i] = (up[i] - down[i]) / (2 * h);
  CHECK(relative_difference(du, up) < 1e-4);
}

TEST_CASE("scalars have their definitions' values") {
  // A column pressed evenly: every mean of the stress is that stress.
  const Mesh mesh = block(even(0, .1, 2), {{0, .03, .1}}, even(0, .1, 2));
  StaticModel model;
  model.materials = {steel(0)};
  model.fixed = {{"foot", select_nodes(mesh, plane(2, 0)), {true, true, true}, {}}};
  model.loads = {Pressure{"top", select_faces(mesh, plane(2, .1)), 5e6}};
  StaticAnalysis analysis = solve_static(mesh, model);
  for (const auto kind :
       {StressScalar::Kind::mean, StressScalar::Kind::volume_mean, StressScalar::Kind::p_norm}) {
    CHECK(stress_scalar(mesh, model, analysis, {kind, StressMeasure::von_mises, 8}, {}).value ==
          doctest::Approx(5e6).epsilon(1e-9));
    CHECK(stress_scalar(mesh, model, analysis, {kind, StressMeasure::max_shear, 8}, {}).value ==
          doctest::Approx(2.5e6).epsilon(1e-9));
  }
  CHECK(mentions(refusal([&] {
                   (void)stress_scalar(mesh, model, analysis,
                                       {StressScalar::Kind::p_norm, StressMeasure::von_mises, 0},
                                       {});
                 }),
                 "p-norm"));
  // A bent beam: the p-norm rises with p towards the largest.
  const Cantilever beam(block(even(0, .2, 10), even(0, .02, 1), even(0, .02, 2)), 0);
  StaticAnalysis bent = solve_static(beam.mesh, beam.model);
  const auto s =
      equivalent_stress(element_stress(beam.mesh, beam.model.materials, bent.solution.displacement),
                        StressMeasure::von_mises);
  const double largest = *std::max_element(s.begin(), s.end());
  double below = 0;
  for (const double p : {1., 4., 20., 400.}) {
    const double norm = stress_scalar(beam.mesh, beam.model, bent,
                                      {StressScalar::Kind::p_norm, StressMeasure::von_mises, p}, {})
                            .value;
    CHECK(norm > below);
    CHECK(norm < largest * (1 + 1e-9));
    below = norm;
  }
  CHECK(below > .98 * largest);
}

TEST_CASE("the volume's gradient is that of the moved mesh") {
  FullModel part(true);
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

TEST_CASE("derivatives of eigenvalues are those of a re-solve, pairs too") {
  set_solver_threads(1);
  const Mesh mesh = block(even(0, .1, 8), even(0, .012, 2), even(0, .01, 2));
  const Lattice lattice{{{0, 0, 0}, {.1, .012, .01}}, {4, 2, 2}, {3, 1, 1}};
  const std::vector<ShapeParameter> parameters{
      {"thicker", {lattice.control(1, 0, 1), lattice.control(1, 1, 1)}, {0, 0, 1}},
      {"longer",
       {lattice.control(3, 0, 0), lattice.control(3, 1, 0), lattice.control(3, 0, 1),
        lattice.control(3, 1, 1)},
       {1, 0, 0}}};
  const auto velocities = design_velocities(embed(mesh, lattice), parameters);
  const std::vector<Material> materials{steel()};
  const std::vector<SpringPatch> springs{{"bed", select_faces(mesh, plane(1, 0)), {1e6, 2e6, 3e6}}};
  const auto solve = [&](const Mesh& own) {
    Matrices matrices = assemble(own, materials, {});
    add_springs(own, springs, matrices);
    ModeSettings settings;
    settings.count = 5;
    return find_modes(own, materials, matrices, settings);
  };
  const Modes modes = solve(mesh);
  const auto slopes = eigenvalue_sensitivity(mesh, materials, springs,
                                             {modes.frequency_hz, modes.shapes, 4}, velocities);
  for (std::size_t p = 0; p < 2; ++p) {
    const double h = 1e-6;
    const Modes up = solve(moved_mesh(mesh, velocities[p], h)),
                down = solve(moved_mesh(mesh, velocities[p], -h));
    for (std::size_t k = 0; k < 4; ++k) {
      const auto lambda = [&](const Modes& m) {
        const double omega = 2 * std::numbers::pi * m.frequency_hz[k];
        return omega * omega;
      };
      const double slope = (lambda(up) - lambda(down)) / (2 * h);
      CHECK(slopes[4 * p + k] == doctest::Approx(slope).epsilon(2e-5));
    }
  }
  CHECK(mentions(refusal([&] {
                   (void)eigenvalue_sensitivity(mesh, materials, springs,
                                                {modes.frequency_hz, modes.shapes, 5}, velocities);
                 }),
                 "goes on beyond the 5 modes given"));
  CHECK(mentions(refusal([&] {
                   (void)eigenvalue_sensitivity(mesh, materials, springs,
                                                {modes.frequency_hz, modes.shapes, 6}, velocities);
                 }),
                 "derivatives of 6 modes"));
}

TEST_CASE("a square bar's pair of bending modes parts as its two thicknesses do") {
  set_solver_threads(1);
  const Mesh mesh = block(even(0, .1, 8), even(0, .01, 2), even(0, .01, 2));
  const Lattice lattice{{{0, 0, 0}, {.1, .01, .01}}, {3, 2, 2}, {2, 1, 1}};
  const std::vector<ShapeParameter> thicker{
      {"thicker", {lattice.control(1, 0, 1), lattice.control(1, 1, 1)}, {0, 0, 1}}};
  const auto velocities = design_velocities(embed(mesh, lattice), thicker);
  const std::vector<Material> materials{steel()};
  const auto solve = [&](const Mesh& own) {
    const Matrices matrices = assemble(own, materials, {});
    ModeSettings settings;
    settings.count = 6;
    return find_modes(own, materials, matrices, settings);
  };
  const Modes modes = solve(mesh);
  CHECK(modes.frequency_hz[1] - modes.frequency_hz[0] < 1e-5 * modes.frequency_hz[0]);
  const auto slopes = eigenvalue_sensitivity(mesh, materials, {},
                                             {modes.frequency_hz, modes.shapes, 2}, velocities);
  // The sides of the difference are two branches that cross at the square: ascending above it,
  // exchanged below.
  const double h = 2e-6;
  const auto lambda = [&](const Modes& m, std::size_t k) {
    const double omega = 2 * std::numbers::pi * m.frequency_hz[k];
    return omega * omega;
  };
  const Modes up = solve(moved_mesh(mesh, velocities[0], h)),
              down = solve(moved_mesh(mesh, velocities[0], -h));
  CHECK(slopes[0] == doctest::Approx((lambda(up, 0) - lambda(down, 1)) / (2 * h)).epsilon(1e-4));
  CHECK(slopes[1] == doctest::Approx((lambda(up, 1) - lambda(down, 0)) / (2 * h)).epsilon(1e-4));
  CHECK(slopes[1] > 3 * std::abs(slopes[0])); // bending across the thicker side stiffens
  // Asked for half a pair, with the other half given but not what follows.
  CHECK(mentions(refusal([&] {
                   (void)eigenvalue_sensitivity(mesh, materials, {},
                                                {std::span(modes.frequency_hz).first(2),
                                                 std::span(modes.shapes).first(2 * mesh.dofs()), 1},
                                                velocities);
                 }),
                 "may belong to a group"));
}
