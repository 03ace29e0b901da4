// Stress tables as files: what is read where, and one sentence for every damage.
#include "files/tables.hpp"
#include "tests/core/stress/tables.hpp"
#include "tests/files/archives.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

using namespace tactus;
using namespace tactus::test;
using files::read_stress_table;
using stress::StressTable;

namespace {

/// Arrays of a small sound file with everything in it.
std::vector<Member> small_stress_table() {
  const std::string meta =
      R"({"format":"stress-table","version":"1.0","name":"four","material":{"name":"steel"},)"
      R"("loads":"1 N","units":{"stress":"Pa","length":"m"}})";
  const std::vector<double> two{1, 2, 3, 4, 5, 6, 7, 8};
  return {
      {"meta", "|u1", {meta.size()}, meta},
      {"s0", "<f8", {4}, raw(std::vector<double>{10, 20, 30, 40})},
      {"S", "<f8", {2, 4}, raw(two)},
      {"shear0", "<f4", {4}, raw(std::vector<float>{5, 6, 7, 8})},
      {"S_shear", "<f4", {2, 4}, raw(std::vector<float>{8, 7, 6, 5, 4, 3, 2, 1})},
      {"weights", "<f8", {4}, raw(std::vector<double>{1e-6, 2e-6, 3e-6, 4e-6})},
      {"parameters", "<f8", {2, 4}, raw(std::vector<double>{1, 0, -0.01, 0.02, 0, 2, 0, 0.03})},
      {"control_points", "<f8", {2, 3}, raw(std::vector<double>{0, 0.1, 0.2, 0.3, 0.4, 0.5})},
      {"trust", "<f8", {}, raw(std::vector<double>{0.005})},
      {"surface_nodes", "<f4", {3, 3}, raw(std::vector<float>{0, 0, 0, 1, 0, 0, 0, 1, 0})},
      {"surface_triangles", "<i4", {1, 3}, raw(std::vector<std::int32_t>{0, 1, 2})},
      {"surface_weights", "<f4", {3, 2}, raw(std::vector<float>{1, 0, 0.5F, 0.5F, 0, 1})},
      {"surface_node_element", "<i4", {3}, raw(std::vector<std::int32_t>{3, 2, 0})},
  };
}

using D = std::vector<double>;

std::string refusal_with(const Change& change) {
  auto members = small_stress_table();
  change(members);
  StressTable table = four_elements();
  const std::string refusal = read_stress_table(bytes_of(archive(members)), table);
  if (!refusal.empty()) // the table is as it was
    CHECK((table.elements() == 4 && table.parameters.size() == 3));
  return refusal;
}
std::string refusal_with(const char* name, D numbers, std::vector<std::size_t> shape) {
  return refusal_with(array(name, std::move(numbers), std::move(shape)));
}

} // namespace

TEST_CASE("every array of a stress table is read with its units") {
  StressTable table;
  REQUIRE(read_stress_table(bytes_of(archive(small_stress_table())), table) == "");
  CHECK(table.elements() == 4);
  CHECK(table.base.von_mises.stress == std::vector<float>{10, 20, 30, 40});
  CHECK(table.base.von_mises.sensitivity == std::vector<float>{1, 2, 3, 4, 5, 6, 7, 8});
  CHECK(table.has_shear());
  CHECK(table.base.max_shear.stress == std::vector<float>{5, 6, 7, 8});
  CHECK(table.base.max_shear.sensitivity == std::vector<float>{8, 7, 6, 5, 4, 3, 2, 1});
  CHECK(table.base.displacement_m == std::vector<double>{0, 0});
  CHECK(table.weight == std::vector<float>{1e-6F, 2e-6F, 3e-6F, 4e-6F});
  REQUIRE(table.parameters.size() == 2);
  CHECK(table.parameters[0].control_point == 1);
  CHECK(table.parameters[0].axis == 0);
  CHECK(table.parameters[0].low_m == -0.01);
  CHECK(table.parameters[0].high_m == 0.02);
  CHECK(table.parameters[1].control_point == 0);
  CHECK(table.parameters[1].axis == 2);
  CHECK(table.control_point_m[1] == Vec3{0.3, 0.4, 0.5});
  CHECK(table.trust_m == 0.005);
  CHECK(table.surface_node_m[1] == Vec3{1, 0, 0});
  CHECK(table.surface_triangle[0] == std::array<std::int32_t, 3>{0, 1, 2});
  CHECK(table.surface_node_element == std::vector<std::int32_t>{3, 2, 0});
  CHECK(table.surface_weight == std::vector<float>{1, 0, 0.5F, 0.5F, 0, 1});
  CHECK(table.name == "four");
  CHECK(table.material == "steel");
  CHECK(table.loads == "1 N");
}

TEST_CASE("shear, volumes and the surface may be left out, each whole") {
  StressTable table;
  auto members = small_stress_table();
  std::erase_if(members, [](const Member& m) {
    return m.name.find("shear") != std::string::npos || m.name == "weights" ||
           m.name.starts_with("surface");
  });
  REQUIRE(read_stress_table(bytes_of(archive(members)), table) == "");
  CHECK(!table.has_shear());
  CHECK(table.weight.empty());
  CHECK(table.surface_node_m.empty());
  for (const char* name : {"meta", "s0", "S", "shear0", "S_shear", "parameters", "control_points",
                           "trust", "surface_triangles", "surface_node_element"})
    mentions(refusal_with(without(name)), {"array", name, "missing"});
}

TEST_CASE("damage is one sentence with the array, what it is and what was expected") {
  mentions(refusal_with("s0", D{1, 2, 3}, {3}), {"'S'", "(2, 4)", "expected (2, 3)"});
  mentions(refusal_with("s0", D{1, 2, 3, 4}, {2, 2}), {"'s0'", "(2, 2)", "expected (any)"});
  mentions(refusal_with("s0", D{1, 2, -3, 4}, {4}), {"'s0'", "0..1e+15 Pa"});
  mentions(refusal_with("s0", D{1, 2, 3e15, 4}, {4}), {"'s0'", "0..1e+15 Pa"});
  mentions(refusal_with("s0", D{1, 2, NAN, 4}, {4}), {"'s0'", "not a finite number"});
  mentions(refusal_with("s0", D{}, {0}), {"'s0'", "empty"});
  mentions(refusal_with("S", D{1, 2, 3, 4}, {1, 4}), {"'S'", "(1, 4)", "expected (2, 4)"});
  mentions(refusal_with("S", D{1, 2, 3, 4, 5, 6, 7, 1e300}, {2, 4}),
           {"'S'", "not a finite number"});
  mentions(refusal_with("shear0", D{1, 2, 3}, {3}), {"'shear0'", "(3)", "expected (4)"});
  mentions(refusal_with("weights", D{1, 2, 3}, {3}), {"'weights'", "expected (4)"});
  mentions(refusal_with("weights", D{1, 2, 0, 4}, {4}), {"'weights'", "volumes"});
  mentions(refusal_with("weights", D{1, 2, 2e12, 4}, {4}), {"'weights'", "volumes"});
  mentions(refusal_with("trust", D{0}, {}), {"'trust'", "0 m", "more than 0"});
  mentions(refusal_with("trust", D{1, 2}, {2}), {"'trust'", "(2)", "expected ()"});
  mentions(refusal_with("control_points", D{0, 0, 2e4, 0, 0, 0}, {2, 3}),
           {"'control_points'", "metres"});
  const auto rows = [](D numbers) {
    const std::size_t count = numbers.size() / 4;
    return refusal_with("parameters", numbers, {count, 4});
  };
  mentions(rows({2, 0, -1, 1}), {"row 0", "control point 2", "expected 0..1"});
  mentions(rows({-1, 0, -1, 1}), {"row 0", "control point -1"});
  mentions(rows({0.5, 0, -1, 1}), {"row 0", "control point 0.5"});
  mentions(rows({0, 3, -1, 1}), {"row 0", "axis 3", "0, 1 or 2"});
  mentions(rows({0, 0, 0.1, 1}), {"row 0", "0.1..1", "low <= 0 <= high"});
  mentions(rows({0, 0, -1, -0.5}), {"row 0", "low <= 0 <= high"});
  mentions(rows({0, 0, 0, 0}), {"row 0", "low <= 0 <= high"});
  mentions(rows({0, 0, -2e4, 0}), {"row 0", "low <= 0 <= high"});
  mentions(rows({0, 1, -1, 1, 0, 1, -1, 1}), {"row 1", "twice"});
  mentions(rows({}), {"'parameters'", "0 rows", "1..6"});
  mentions(refusal_with("surface_triangles", D{0, 1, 3}, {1, 3}),
           {"'surface_triangles'", "corner 3"});
  mentions(refusal_with("surface_triangles", D{0, 1, -1}, {1, 3}),
           {"'surface_triangles'", "corner -1"});
  mentions(refusal_with("surface_node_element", D{0, 1, 4}, {3}),
           {"'surface_node_element'", "4 of 4"});
  mentions(refusal_with("surface_node_element", D{0, 1, .5}, {3}), {"'surface_node_element'"});
  mentions(refusal_with("surface_weights", D{0, 1, 0, 1}, {2, 2}), {"'surface_weights'"});
  mentions(refusal_with("surface_weights", D{0, 1, 0, 1, 0, NAN}, {3, 2}),
           {"'surface_weights'", "not a finite number"});
}

TEST_CASE("a table's description says what it is and in which units") {
  const auto described = [](const std::string& text) { return refusal_with(meta(text)); };
  CHECK(described(R"({"format":"stress-table","version":"1"})") == "");
  CHECK(described(R"({"format":"stress-table","version":"1.7"})") == "");
  mentions(described(R"({"format":"modal-table","version":"1"})"),
           {"not a stress table", "modal-table"});
  mentions(described(R"({"format":"stress-table","version":"2"})"), {"version '2'"});
  mentions(described(R"({"format":"stress-table","version":"1","units":{"stress":"MPa"}})"),
           {"stress is in MPa", "expected Pa"});
  mentions(described(R"({"format":"stress-table","version":"1","units":{"length":"mm"}})"),
           {"length is in mm", "expected m"});
  mentions(described("nonsense"), {"'meta'", "JSON"});
}

TEST_CASE("too many control points are refused before they are read") {
  mentions(refusal_with("control_points", D(3 * 4097), {4097, 3}), {"4097 points", "at most 4096"});
}
