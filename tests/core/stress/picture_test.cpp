// The side view of a part: which faces, where and with what stress.
#include "core/stress/stress_picture.hpp"
#include "core/stress/stress_session.hpp"
#include "tests/core/stress/tables.hpp"

#include <doctest/doctest.h>

#include <limits>

using namespace tactus;
using namespace tactus::test;
using stress::Picture;
using stress::PictureFace;
using stress::StressModel;
using stress::StressPicture;
using stress::StressTable;

namespace {

/// Two triangles that face the viewer, the nearer one first, one that looks away and one edge on.
/// Control points 0 and 1 move along x and y; a node moves by (1 - x) of the first and x of the
/// other.
StressTable plate() {
  StressTable table;
  table.base.von_mises = {{10, 20, 60}, {1e3F, 0, 0, 0, 2e3F, 3e3F}};
  table.base.displacement_m = {0, 0};
  table.parameters = {{0, 0, -1, 1}, {1, 1, -1, 1}};
  table.control_point_m = {{0, 0, 0}, {1, 0, 0}};
  table.trust_m = 0.01;
  table.surface_node_m = {{0, 0, 1}, {1, 0, 1}, {0, 1, 1}, {0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  table.surface_triangle = {{0, 1, 2}, {3, 4, 5}, {3, 5, 4}, {0, 3, 1}};
  table.surface_node_element = {0, 1, 2, 2, 2, 2};
  for (const auto& node : table.surface_node_m) {
    table.surface_weight.push_back(static_cast<float>(1 - node.x));
    table.surface_weight.push_back(static_cast<float>(node.x));
  }
  return table;
}

std::shared_ptr<const Picture> drawn(const std::shared_ptr<const StressTable>& table,
                                     std::vector<double> displacement_m) {
  return StressPicture(*table).draw(StressModel(table), displacement_m);
}

} // namespace

TEST_CASE("faces that look at the viewer are drawn from the farthest to the nearest") {
  const auto picture = drawn(shared(plate()), {0, 0});
  REQUIRE(picture->faces.size() == 2);
  CHECK(picture->faces[0].stress_pa == doctest::Approx(60));
  CHECK(picture->faces[1].stress_pa == doctest::Approx(30)); // (10 + 20 + 60)/3
  CHECK(picture->faces[1].corner_m == std::array<double, 6>{0, 0, 1, 0, 0, 1});
  CHECK(picture->stress_scale_pa == doctest::Approx(60));
  CHECK(picture->width_m == doctest::Approx(1));
}

TEST_CASE("corners follow the control points by their weights, stresses by their series") {
  const auto picture = drawn(shared(plate()), {0.01, 0.02});
  // Element stresses: 10 + 1e3 0.01, 20 + 2e3 0.02, 60 + 3e3 0.02.
  CHECK(picture->faces[0].stress_pa == doctest::Approx(120));
  CHECK(picture->faces[1].stress_pa == doctest::Approx((20.0 + 60.0 + 120.0) / 3));
  const std::array<double, 6> expected{0.01, 0, 1, 0.02, 0.01, 1};
  for (std::size_t k = 0; k < 6; ++k)
    CHECK(picture->faces[1].corner_m[k] == doctest::Approx(expected[k]));
  CHECK(picture->stress_scale_pa == doctest::Approx(60)); // of the table's shape
}

TEST_CASE("a table without weights keeps its shape, and displacements that are no numbers are 0") {
  StressTable rigid = plate();
  rigid.surface_weight.clear();
  const std::array<double, 6> first{0, 0, 1, 0, 0, 1};
  CHECK(drawn(shared(rigid), {0.01, 0.02})->faces[1].corner_m == first);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto picture = drawn(shared(plate()), {nan, nan});
  CHECK(picture->faces[1].corner_m == first);
  CHECK(picture->faces[1].stress_pa == doctest::Approx(30));
}

TEST_CASE("a table without a surface gives an empty picture") {
  CHECK(drawn(shared(four_elements()), {0, 0, 0})->faces.empty());
}

TEST_CASE(
    "the stress of some elements is the whole series at these elements, about a new base too") {
  const auto table = shared(Cantilever::table());
  StressModel model(table);
  const std::vector<std::size_t> elements{49, 0, 17};
  const std::vector<double> shape{1e-3, -5e-4};
  std::vector<double> found(3);
  model.rebase(std::make_shared<const stress::StressBase>(Cantilever::solve(2e-3, 1e-3)));
  model.stress_of(elements, shape, found);
  const auto& base = model.base().von_mises;
  for (std::size_t i = 0; i < 3; ++i) {
    const std::size_t e = elements[i];
    const double expected =
        static_cast<double>(base.stress[e]) + static_cast<double>(base.sensitivity[e]) * -1e-3 +
        static_cast<double>(base.sensitivity[Cantilever::kElements + e]) * -1.5e-3;
    CHECK(found[i] == doctest::Approx(expected).epsilon(1e-12));
  }
}

TEST_CASE("the peak is the largest stress of an element at the shape at hand") {
  StressModel model(shared(Cantilever::table()));
  const double thinner = model.update(std::vector<double>{-1e-4, -1e-4}).peak_pa;
  // 1st element, to first order: s (1 + 2 1e-4/0.02).
  CHECK(thinner == doctest::Approx(Cantilever::stress_pa(0, 0, 0) * 1.01).epsilon(1e-6));
}

TEST_CASE("a session draws once for each request that asks for it") {
  stress::StressSession session(shared(plate()));
  stress::SessionRequest request;
  request.displacement_m = {0, 0};
  CHECK(session.step(0, request).picture == nullptr);
  request.picture = 1;
  const auto first = session.step(0.001, request).picture;
  REQUIRE(first != nullptr);
  CHECK(session.step(0.002, request).picture == first);
  request.displacement_m = {0.01, 0};
  CHECK(session.step(0.003, request).picture == first);
  request.picture = 2;
  const auto& result = session.step(0.004, request);
  CHECK(result.picture_number == 2);
  CHECK(result.picture->faces[1].corner_m[0] == doctest::Approx(0.01));
}
