// Shape parameters of a table and the slopes of its modes over them.
#include "files/modal_table.hpp"
#include "tests/files/modal_members.hpp"

#include <doctest/doctest.h>

#include <cmath>
#include <string>
#include <vector>

using namespace tactus;
using namespace tactus::modal;
using namespace tactus::test;

TEST_CASE("a table's shape parameters are read, and refused by name and shape") {
  using Doubles = std::vector<double>;
  auto sound = small_table();
  for (const Change& add :
       {array("control_points", Doubles{0, 0, 0, .1, 0, 0}, {2, 3}),
        array("parameters", Doubles{0, 1, -.01, .02, 1, 0, -.03, .04, 1, 2, -.05, .06}, {3, 4}),
        array("trust", Doubles{.005}, {}), array("domega2_dp", Doubles{1, 2, 3, 4, 5, 6}, {3, 2})})
    add(sound);
  ModalTable table;
  REQUIRE(files::read_modal_table(bytes_of(archive(sound)), table) == "");
  const ShapeSensitivity& read = table.sensitivity;
  REQUIRE(read.parameters() == 3);
  CHECK(read.shape.control_point_m[1] == Vec3{.1, 0, 0});
  CHECK(read.shape.parameters[1].control_point == 1);
  CHECK(read.shape.parameters[2].axis == 2);
  CHECK(read.shape.parameters[0].low_m == -.01);
  CHECK(read.shape.parameters[0].high_m == .02);
  CHECK(read.shape.trust_m == .005);
  CHECK(read.eigenvalue_slope == Doubles{1, 2, 3, 4, 5, 6});

  struct Wrong {
    const char* name;
    Doubles numbers;
    std::vector<std::size_t> shape;
    std::vector<std::string> words;
  };
  const Wrong wrong[] = {{"domega2_dp", {1, 2, 3, 4}, {2, 2}, {"(2, 2)", "(3, 2)"}},
                         {"domega2_dp", {1, 2, 3, 4, 5, std::nan("")}, {3, 2}, {"finite"}},
                         {"control_points", {0, 0, 0, 1}, {2, 2}, {"(2, 2)"}},
                         {"control_points", {0, 0, 0, 1e5, 0, 0}, {2, 3}, {"metres"}},
                         {"parameters", {2, 1, -1, 1}, {1, 4}, {"control point 2", "0..1"}},
                         {"parameters", {0, 3, -1, 1}, {1, 4}, {"axis 3"}},
                         {"parameters", {0, 1, 1, 2}, {1, 4}, {"bounds 1..2"}},
                         {"parameters", {0, 1, -1, 1, 0, 1, -1, 1}, {2, 4}, {"twice"}},
                         {"parameters", {}, {0, 4}, {"1..6"}},
                         {"trust", {0}, {}, {"more than 0"}}};
  for (const Wrong& one : wrong) {
    auto members = sound;
    array(one.name, one.numbers, one.shape)(members);
    ModalTable unchanged;
    const std::string refusal = files::read_modal_table(bytes_of(archive(members)), unchanged);
    CHECK(unchanged.frequency_hz.empty());
    mentions(refusal, {one.name});
    for (const std::string& word : one.words)
      mentions(refusal, {word});
  }
}
