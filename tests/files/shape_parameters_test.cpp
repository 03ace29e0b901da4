// Shape parameters of a table and the slopes of its modes over them.
#include "files/modal_table.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <initializer_list>
#include <string>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;
using files::read_modal_table;

namespace {

/// The small table with two control points and three parameters, one of which is to be changed.
std::string refusal_with(const char* name, const std::vector<double>& values,
                         const std::vector<std::size_t>& shape, ModalTable* read = nullptr) {
  auto members = small_table();
  const auto add = [&](const char* array, std::vector<std::size_t> extents,
                       std::vector<double> numbers) {
    if (array == std::string(name)) {
      extents = shape;
      numbers = values;
    }
    members.push_back({array, "<f8", extents, raw(numbers)});
  };
  add("control_points", {2, 3}, {0, 0, 0, .1, 0, 0});
  add("parameters", {3, 4}, {0, 1, -.01, .02, 1, 0, -.03, .04, 1, 2, -.05, .06});
  add("trust", {}, {.005});
  add("domega2_dp", {3, 2}, {1, 2, 3, 4, 5, 6});
  ModalTable table;
  const std::string refusal = read_modal_table(bytes_of(archive(members)), table);
  CHECK((refusal.empty() || table.frequency_hz.empty())); // as it was
  if (read)
    *read = table;
  return refusal;
}

} // namespace

TEST_CASE("a table's shape parameters are read, and refused by name and shape") {
  ModalTable table;
  REQUIRE(refusal_with("", {}, {}, &table).empty());
  const ShapeSensitivity& read = table.sensitivity;
  REQUIRE(read.parameters() == 3);
  CHECK(read.shape.control_point_m[1] == Vec3{.1, 0, 0});
  CHECK(read.shape.parameters[1].control_point == 1);
  CHECK(read.shape.parameters[2].axis == 2);
  CHECK(read.shape.parameters[0].low_m == -.01);
  CHECK(read.shape.parameters[0].high_m == .02);
  CHECK(read.shape.trust_m == .005);
  CHECK(read.eigenvalue_slope == std::vector<double>{1, 2, 3, 4, 5, 6});

  const auto says = [](const std::string& sentence, std::initializer_list<const char*> words) {
    CAPTURE(sentence);
    for (const char* word : words)
      CHECK(sentence.find(word) != std::string::npos);
  };
  says(refusal_with("domega2_dp", {1, 2, 3, 4}, {2, 2}), {"domega2_dp", "(2, 2)", "(3, 2)"});
  says(refusal_with("domega2_dp", {1, 2, 3, 4, 5, std::nan("")}, {3, 2}), {"domega2_dp", "finite"});
  says(refusal_with("control_points", {0, 0, 0, 1}, {2, 2}), {"control_points", "(2, 2)"});
  says(refusal_with("control_points", {0, 0, 0, 1e5, 0, 0}, {2, 3}), {"control_points", "metres"});
  says(refusal_with("parameters", {2, 1, -1, 1}, {1, 4}),
       {"parameters", "control point 2", "0..1"});
  says(refusal_with("parameters", {0, 3, -1, 1}, {1, 4}), {"parameters", "axis 3"});
  says(refusal_with("parameters", {0, 1, 1, 2}, {1, 4}), {"parameters", "bounds 1..2"});
  says(refusal_with("parameters", {0, 1, -1, 1, 0, 1, -1, 1}, {2, 4}), {"parameters", "twice"});
  says(refusal_with("parameters", {}, {0, 4}), {"parameters", "1..6"});
  says(refusal_with("trust", {0}, {}), {"trust", "more than 0"});
}
