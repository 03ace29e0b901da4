// The predicted cost of a body that is not meshed yet, against its mesh and factor.
#include "fem/modes/cost.hpp"

#include "fem/material/material.hpp"
#include "fem/shapes/shapes.hpp"

#include <cmath>
#include <doctest/doctest.h>

namespace tactus::fem {
namespace {

struct Body {
  const char* name;
  std::map<std::string, double> millimetres;
  double h; ///< mm; 0: the standard size
};

ShapePlan plan(const Body& body, MeshChoice choice = {}) {
  auto dimensions = body.millimetres;
  for (auto& [name, value] : dimensions)
    if (name != "angle")
      value *= 1e-3;
  choice.h = 1e-3 * body.h;
  return plan_shape(body.name, dimensions, {}, choice);
}

void check_counts(const ShapePlan& planned, const Mesh& mesh) {
  CHECK(planned.size.elements == static_cast<double>(mesh.elements.size()));
  CHECK(planned.size.nodes == static_cast<double>(mesh.nodes.size()));
}

const std::vector<Body>& bodies() {
  static const std::vector<Body> all{
      {"disk", {{"diameter", 100}, {"thickness", 12}}, 0},
      {"disk", {{"diameter", 100}, {"thickness", 12}, {"patch_diameter", 4}}, 8},
      {"hollow_disk",
       {{"diameter", 100}, {"thickness", 25}, {"cavity_diameter", 80}, {"cavity_thickness", 13}},
       12},
      {"ring", {{"outer_diameter", 100}, {"inner_diameter", 60}, {"thickness", 8}}, 5},
      {"tube", {{"outer_diameter", 40}, {"inner_diameter", 34}, {"length", 300}}, 0},
      {"plate", {{"length", 300}, {"width", 200}, {"thickness", 5}}, 10},
      {"plate", {{"length", 60}, {"width", 60}, {"thickness", 60}}, 6},
      {"bar", {{"length", 400}, {"width", 30}, {"thickness", 10}}, 5},
      {"bar", {{"length", 200}, {"diameter", 20}}, 4},
      {"sphere", {{"diameter", 100}}, 10},
      {"hollow_sphere", {{"diameter", 100}, {"thickness", 5}}, 8},
      {"bowl", {{"diameter", 200}, {"thickness", 4}, {"angle", 120}}, 9},
  };
  return all;
}

TEST_CASE("a shape's elements and nodes are counted exactly before it is made") {
  for (const Body& body : bodies()) {
    CAPTURE(body.name);
    const ShapePlan planned = plan(body);
    const Mesh mesh = planned.make().mesh;
    check_counts(planned, mesh);
    // Pairs round the axis of revolution are left out: below a tenth of a slender round bar's.
    const double pairs = static_cast<double>(NodeGraph(mesh).row.size());
    CHECK(planned.size.node_pairs == doctest::Approx(pairs).epsilon(.06));
    CHECK(planned.size.volume == doctest::Approx(volume(mesh)).epsilon(.03)); // flat facets
    const Vec3 box = bounding_box(mesh.nodes).size();
    for (int k = 0; k < 3; ++k) // an open bowl's lower half is all that differs
      CHECK(planned.size.box[k] == doctest::Approx(box[k]).epsilon(.06));
  }
}

/// A grid with every third interval halved, and four more sectors around an axis.
SweepGrid uneven(const SweepGrid& grid) {
  SweepGrid finer = grid;
  for (std::size_t d = 0; d < 3; ++d) {
    std::vector<double>& line = finer.line[d];
    const std::vector<double>& old = grid.line[d];
    line.clear();
    if (const std::size_t step = static_cast<std::size_t>(grid.uniform[d]); step > 0) {
      const std::size_t count = old.size() - 1 + step;
      for (std::size_t i = 0; i <= count; ++i)
        line.push_back(old.back() * static_cast<double>(i) / static_cast<double>(count));
      continue;
    }
    for (std::size_t i = 0; i + 1 < old.size(); ++i) {
      line.push_back(old[i]);
      if (i % 3 == d)
        line.push_back(.5 * (old[i] + old[i + 1]));
    }
    line.push_back(old.back());
  }
  return finer;
}

TEST_CASE("first meshes of few elements and those of a refinement's grid are counted exactly") {
  for (const Body& body : bodies()) {
    CAPTURE(body.name);
    const ShapePlan sparse = plan(body, {.sparse = true});
    const SweptBody first = sparse.make();
    check_counts(sparse, first.mesh);
    const SweepGrid grid = uneven(first.grid);
    const ShapePlan refined = plan(body, {.sparse = true, .grid = &grid});
    const SweptBody second = refined.make();
    check_counts(refined, second.mesh);
    CHECK(refined.size.elements > sparse.size.elements);
    for (std::size_t d = 0; d < 3; ++d)
      CHECK(second.grid.line[d].size() == grid.line[d].size());
    CHECK(volume(second.mesh) == doctest::Approx(volume(first.mesh)).epsilon(.03));
  }
}

namespace {

void check_factor(const Body& body) {
  CAPTURE(body.name);
  const Material aluminium = find_material("aluminium");
  const ShapePlan planned = plan(body);
  const Matrices matrices = assemble(planned.make().mesh, std::span(&aluminium, 1), {});
  const FactorCost exact = ShiftedFactor(matrices, 1e6).cost(),
                   foretold = predict_factor(planned.size);
  const auto within = [](double ratio, double factor) {
    CHECK(ratio > 1 / factor);
    CHECK(ratio < factor);
  };
  within(foretold.entries / exact.entries, 1.6);
  within(foretold.operations / exact.operations, 2);
  within(foretold.memory_bytes / exact.memory_bytes, 1.4);
}

} // namespace

TEST_CASE("the factor's entries are foretold within a factor of 1.6, be the body a bar or a ball") {
  check_factor({"bar", {{"length", 400}, {"width", 30}, {"thickness", 10}}, 10});
  check_factor({"sphere", {{"diameter", 100}}, 20});
}

TEST_CASE("the factor's entries are foretold within a factor of 1.6 for every shape" *
          doctest::test_suite("slow")) {
  for (const Body& body : bodies())
    check_factor(body);
}

TEST_CASE("in the limit of fine meshes a cube's factor grows as n^(4/3), a plate's as n log n") {
  const auto growth = [](std::map<std::string, double> sides, double h) {
    const MeshSize coarse = plan({"plate", sides, h}).size,
                   fine = plan({"plate", sides, h / 4}).size;
    return std::pair(predict_factor(fine).entries / predict_factor(coarse).entries,
                     fine.nodes / coarse.nodes);
  };
  const auto [cube, cube_nodes] =
      growth({{"length", 100}, {"width", 100}, {"thickness", 100}}, .01);
  CHECK(std::log(cube) / std::log(cube_nodes) == doctest::Approx(4. / 3).epsilon(.01));
  MeshSize thin{.cells = {1000, 1000, 3}}, finer{.cells = {4000, 4000, 3}};
  const double grown = predict_factor(finer).entries / predict_factor(thin).entries;
  CHECK(grown > 16); // more than n
  CHECK(grown < 16 * 1.35);
}

TEST_CASE("absurd element sizes are counted at once, and refused when made") {
  for (const Body& body : bodies())
    for (const double h : {1e-12, 1e-9, 1e-3, 1e9}) {
      CAPTURE(body.name);
      CAPTURE(h);
      const ShapePlan planned = plan({body.name, body.millimetres, h});
      const Cost cost = predict_cost({.mesh = planned.size});
      CHECK(std::isfinite(cost.bytes));
      CHECK(std::isfinite(cost.seconds));
      CHECK(cost.bytes > (h < 1e-2 ? 1e13 : 0));
      if (h < 1e-2)
        CHECK_THROWS_AS((void)planned.make(), InputError);
      else
        CHECK(cost.bytes < 1e9);
    }
}

TEST_CASE("tetrahedra's numbers follow from volume, skin and element size") {
  // Of gmsh 4.8's meshes: block 60 x 50 x 40 mm at 3 mm 21 770 tetrahedra and 32 946 nodes, sheet
  // 200 x 120 x 3 mm at 6 mm 5216 and 10 724.
  const MeshSize block = predict_tetrahedra(1.2e-4, 1.48e-2, {.06, .05, .04}, .003);
  CHECK(block.elements == doctest::Approx(21770).epsilon(.1));
  CHECK(block.nodes == doctest::Approx(32946).epsilon(.1));
  CHECK(block.node_pairs == doctest::Approx(4.57e5).epsilon(.1));
  const MeshSize sheet = predict_tetrahedra(7.2e-5, 4.992e-2, {.2, .12, .003}, .006);
  CHECK(sheet.elements == doctest::Approx(5216).epsilon(.1));
  CHECK(sheet.nodes == doctest::Approx(10724).epsilon(.1));
  const MeshSize finer = resized_tetrahedra(block, .0015);
  CHECK(finer.elements == doctest::Approx(8 * block.elements).epsilon(.15));
}

TEST_CASE("the work grows with modes, the air and the compliance") {
  const MeshSize mesh = plan(bodies()[0]).size;
  const double usual = predict_cost({.mesh = mesh}).bytes;
  CHECK(predict_cost({.mesh = mesh, .modes = 400}).bytes > 1.3 * usual);
  CHECK(predict_cost({.mesh = mesh, .acoustic_triangles = 20000}).bytes > 16e8);
  CHECK(predict_cost({.mesh = mesh, .residual = true}).seconds >
        predict_cost({.mesh = mesh}).seconds);
}

} // namespace
} // namespace tactus::fem
