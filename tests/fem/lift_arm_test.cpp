// The lift arm: its solid against closed forms, its topology, its holes, and what it refuses.
#include "fem/mesh/surface.hpp"
#include "fem/shapes/lift_arm.hpp"
#include "solve.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

/// Through how many holes one can pass a finger: V - E + F = 2 - 2 g of a closed connected skin.
int genus(const Mesh& mesh) {
  const Surface skin = surface_of(mesh);
  std::set<std::array<int, 2>> edges;
  for (const auto& t : skin.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      edges.insert({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3])});
  const int euler = static_cast<int>(skin.node.size()) - static_cast<int>(edges.size()) +
                    static_cast<int>(skin.triangles.size());
  return (2 - euler) / 2;
}

/// Elements of one size everywhere, which a volume does not mind.
LoadChoice even(double h) {
  LoadChoice choice;
  choice.h = h;
  choice.grade_concave = false;
  return choice;
}

const Mesh& mesh_of_the_arm() {
  static const Mesh mesh = mesh_lift_arm(LiftArm{}, even(.016));
  return mesh;
}

} // namespace

TEST_CASE("the lift arm's mesh has the volume of the closed form, and its holes") {
  // Curved tet10 with 12 sides a turn: a parabola follows an arc of 30 degrees within 1e-4 of its
  // radius, with both signs.
  const LiftArm arm;
  const Mesh& with = mesh_of_the_arm();
  CHECK(volume(with) == doctest::Approx(volume(arm)).epsilon(6e-5));
  CHECK(genus(with) == 5); // three pins, two lightening holes
  CHECK(connected_parts(with).count == 1);
}

TEST_CASE("the closed form holds without lightening holes" * doctest::test_suite("slow")) {
  LiftArm arm;
  arm.slot_width = 0;
  const Mesh solid = mesh_lift_arm(arm, even(.016));
  CHECK(volume(solid) == doctest::Approx(volume(arm)).epsilon(6e-5));
  CHECK(genus(solid) == 3);
}

TEST_CASE("fillets and rounded edges have the volume that Pappus and Guldin give them" *
          doctest::test_suite("slow")) {
  LiftArm sharp, rounded;
  rounded.edge_radius = .004;
  const double made = volume(mesh_lift_arm(rounded, even(.02)));
  CHECK(made == doctest::Approx(volume(rounded)).epsilon(6e-5));
  // Without the term the difference would be this large:
  CHECK(volume(sharp) / volume(rounded) - 1 > 2e-3);
  LiftArm small = sharp;
  small.fillet = .002;
  CHECK(volume(sharp) / volume(small) - 1 > 5e-3);
}

TEST_CASE("the walls of the three holes are named, round, and where the pins are") {
  const LiftArm arm;
  const Mesh& mesh = mesh_of_the_arm();
  for (const Pin& pin : pins(arm)) {
    CAPTURE(pin.name);
    const auto& nodes = mesh.node_sets.at(pin.name);
    REQUIRE(nodes.size() > 20);
    double low = 1, high = -1;
    for (const int n : nodes) {
      const Vec3& p = mesh.nodes[static_cast<std::size_t>(n)];
      CHECK(std::hypot(p.x - pin.centre.x, p.y - pin.centre.y) ==
            doctest::Approx(pin.radius).epsilon(1e-5));
      low = std::min(low, p.z);
      high = std::max(high, p.z);
    }
    CHECK(high - low == doctest::Approx(pin.width).epsilon(1e-9));
  }
  const auto all = pins(arm);
  CHECK(all[0].centre == Vec3{});
  CHECK(length(all[2].centre - Vec3{arm.length, 0, 0}) < 1e-12);
  // The lift eye lies on the arc through both ends with the given rise.
  const double r = (arm.length * arm.length / 4 + arm.rise * arm.rise) / (2 * arm.rise);
  CHECK(length(all[1].centre - Vec3{arm.length / 2, arm.rise - r, 0}) == doctest::Approx(r));
}

TEST_CASE("the STEP file is one solid that is read back whole") {
  const LiftArm arm;
  const auto path = std::filesystem::temp_directory_path() / "tactus_lift_arm_test.step";
  write_step(path.string(), arm);
  std::ifstream file(path);
  std::string first;
  std::getline(file, first);
  CHECK(first.starts_with("ISO-10303-21;"));
  const Mesh mesh = load_body(path.string(), even(.02)); // in mm, as STEP files say
  CHECK(volume(mesh) == doctest::Approx(volume(arm)).epsilon(1e-3));
  std::filesystem::remove(path);
  CHECK_THROWS_AS(write_step("/nowhere/arm.step", arm), InputError);
}

TEST_CASE("dimensions that cannot be built are refused by name and value") {
  const auto refused = [](const auto& change, const char* words) {
    LiftArm arm;
    change(arm);
    check_refused([&] { check(arm); }, words);
  };
  CHECK_NOTHROW(check(LiftArm{}));
  refused([](LiftArm& a) { a.hub.bore = .2; }, "hub diameter 96 mm");
  refused([](LiftArm& a) { a.rod_eye.width = .020; }, "rod_eye width 20 mm");
  refused([](LiftArm& a) { a.depth = 0; }, "depth 0 mm");
  refused([](LiftArm& a) { a.depth = 2; }, "lift_arm: depth 2000 mm");
  refused([](LiftArm& a) { a.rise = .3; }, "rise 300 mm");
  refused([](LiftArm& a) { a.lift_position = 1.5; }, "lift_position 1.5");
  refused([](LiftArm& a) { a.lift_position = .05; }, "length 380 mm");
  refused([](LiftArm& a) { a.shoulder = .004; }, "shoulder 4 mm");
  refused([](LiftArm& a) { a.lift_eye.diameter = .095; }, "lift_eye diameter 95 mm");
  refused([](LiftArm& a) { a.slot_width = .08; }, "slot_width 80 mm");
  refused([](LiftArm& a) { a.web = .1; }, "slot_width 28 mm");
  refused([](LiftArm& a) { a.edge_radius = .012; }, "edge_radius 12 mm");
  refused([](LiftArm& a) { a.thickness = NAN; }, "thickness nan mm");
  refused([](LiftArm& a) { a.length = 1e9; }, "length 1e+12 mm");
}
