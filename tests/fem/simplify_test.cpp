// Fine surfaces in fewer triangles, the search tree behind it, and which parts become the body.
#include "fem/mesh/simplify.hpp"

#include "fem/mesh/box_tree.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/distance.hpp"
#include "fem/mesh/holes.hpp"
#include "fem/mesh/parts.hpp"
#include "solve.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <doctest/doctest.h>
#include <map>
#include <random>
#include <set>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

/// A box whose faces have n by n squares of two triangles, bent by `bend`.
template <class Bend> Triangles box_of_squares(const Vec3& size, int n, Bend&& bend) {
  Triangles t;
  std::map<std::array<int, 3>, int> known;
  const auto corner = [&](const std::array<int, 3>& c) {
    const auto [at, added] = known.try_emplace(c, static_cast<int>(t.points.size()));
    if (added)
      t.points.push_back(bend({size.x * c[0] / n, size.y * c[1] / n, size.z * c[2] / n}));
    return at->second;
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const int level : {0, n})
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
          const auto at = [&](int u, int v) {
            std::array<int, 3> c{};
            c[static_cast<std::size_t>(axis)] = level;
            c[static_cast<std::size_t>((axis + 1) % 3)] = u;
            c[static_cast<std::size_t>((axis + 2) % 3)] = v;
            return corner(c);
          };
          const int a = at(i, j), b = at(i + 1, j), c = at(i + 1, j + 1), d = at(i, j + 1);
          if (level == n)
            t.triangles.insert(t.triangles.end(), {{a, b, c}, {a, c, d}});
          else
            t.triangles.insert(t.triangles.end(), {{a, c, b}, {a, d, c}});
        }
  t.shell.assign(t.triangles.size(), 0);
  t.shells = 1;
  return t;
}

Triangles box_of_squares(const Vec3& size, int n) {
  return box_of_squares(size, n, [](const Vec3& p) { return p; });
}

Triangles with_edges(const Triangles& t, double edge, double deviation) {
  return simplified(
      t, [edge](const Vec3&) { return edge; }, deviation);
}

Part part(const std::string& name, double volume, double at) {
  return {name, volume, {{at, 0, 0}, {at + .01, .01, .01}}};
}

} // namespace

TEST_CASE("boxes near a box are found as by looking at each") {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> in(0, 1);
  std::vector<Box> boxes;
  for (int i = 0; i < 500; ++i) {
    const Vec3 low{in(random), in(random), .1 * in(random)};
    boxes.push_back({low, low + Vec3{.1 * in(random), .02, .05 * in(random)}});
  }
  const BoxTree tree(boxes);
  for (int n = 0; n < 50; ++n) {
    const Box wanted = boxes[static_cast<std::size_t>(n)];
    const double distance = .01 * (n % 5);
    std::set<std::size_t> expected, found;
    for (std::size_t i = 0; i < boxes.size(); ++i) {
      bool near = true;
      for (int k = 0; k < 3; ++k)
        near = near && boxes[i].low[k] <= wanted.high[k] + distance &&
               boxes[i].high[k] >= wanted.low[k] - distance;
      if (near)
        expected.insert(i);
    }
    tree.for_each_near(wanted, distance, [&](std::size_t i) { return found.insert(i).second; });
    CHECK(found == expected);
  }
  BoxTree({}).for_each_near(boxes[0], 1, [](std::size_t) {
    FAIL("nothing is in an empty tree");
    return true;
  });
}

TEST_CASE("a flat box of 10 800 triangles keeps its shape to the last digits in few") {
  const Vec3 size{.1, .06, .002};
  const Triangles fine = box_of_squares(size, 30), coarse = with_edges(fine, .01, .0005);
  CHECK(fine.triangles.size() == 10800);
  CHECK(coarse.triangles.size() < 2000);
  CHECK(enclosed(coarse) == doctest::Approx(size.x * size.y * size.z).epsilon(1e-12));
  CHECK(!crossing(coarse));
  Triangles again = coarse;
  CHECK_NOTHROW(close(again));
}

TEST_CASE("a fine ball stays within the deviation") {
  const double radius = .05, deviation = .0003;
  const Triangles fine = box_of_squares({2, 2, 2}, 40, [&](const Vec3& p) {
    const Vec3 q = p - Vec3{1, 1, 1};
    return (radius / length(q)) * q;
  });
  const Triangles coarse = with_edges(fine, .006, deviation);
  CHECK(coarse.triangles.size() < 6000);
  for (std::size_t i = 0; i < coarse.triangles.size(); ++i) { // the farthest inside
    const Vec3 middle =
        (1. / 3) * (coarse.corner(i, 0) + coarse.corner(i, 1) + coarse.corner(i, 2));
    CHECK(radius - length(middle) < 1.1 * deviation);
  }
  CHECK(enclosed(coarse) / enclosed(fine) == doctest::Approx(1).epsilon(.01));
  CHECK(!crossing(coarse));
}

namespace {

void check_wavy_sheet(double wall, int squares) {
  const Triangles fine = box_of_squares({.1, .1, wall}, squares, [&](const Vec3& p) {
    return p + Vec3{0, 0, .006 * std::sin(90 * p.x) * std::cos(90 * p.y)};
  });
  REQUIRE(!crossing(fine));
  const Triangles coarse = with_edges(fine, .008, .003);
  CHECK(!crossing(coarse));
  CHECK(coarse.triangles.size() < fine.triangles.size());
}

} // namespace

TEST_CASE("walls closer than the deviation do not meet") { check_wavy_sheet(.0004, 24); }

TEST_CASE("walls of any thickness do not meet" * doctest::test_suite("slow")) {
  for (const double wall : {.0002, .0004, .0008})
    check_wavy_sheet(wall, 60);
}

TEST_CASE("a spike that hardly has area stays within the deviation too") {
  const double deviation = .0004;
  for (const double height : {.0005, .0007, .001}) {
    const Triangles fine = box_of_squares({.03, .03, .03}, 24, [&](const Vec3& p) {
      const bool spike = p.z > .0299 && length(p - Vec3{.015, .015, .03}) < 1e-6;
      return p + Vec3{0, 0, spike ? height : 0};
    });
    const Triangles coarse = with_edges(fine, .008, deviation);
    double nearest = 1;
    for (std::size_t i = 0; i < coarse.triangles.size(); ++i)
      nearest =
          std::min(nearest, distance_to_triangle({.015, .015, .03 + height}, coarse.corner(i, 0),
                                                 coarse.corner(i, 1), coarse.corner(i, 2)));
    CHECK(nearest <= deviation);
  }
}

TEST_CASE("neighbours folded onto each other are a crossing") {
  Triangles t;
  t.points = {{0, 0, 0}, {1, 0, 0}, {.4, 1, 0}, {.6, .8, 0}};
  t.triangles = {{0, 1, 2}, {1, 0, 3}};
  CHECK(crossings(t, 10).size() == 1);
  t.points[3].z = .01; // half a degree open
  CHECK(crossings(t, 10).empty());
}

TEST_CASE("debris below one per cent of the body is left out and said, more is several parts") {
  std::string error_text;
  LoadChoice choice;
  choice.notify = [&](const std::string& sentence) { error_text += sentence; };
  const std::vector<Part> crumbs{part("chip", 4e-9, .5), part("bell", 1e-6, 0),
                                 part("dust", 5e-9, .7)};
  CHECK(chosen_parts(crumbs, choice) == std::vector<std::size_t>{1});
  CHECK(error_text.find("2 small pieces") != std::string::npos);
  CHECK(error_text.find("chip (10 mm) near (505, 5, 5) mm") != std::string::npos);
  const std::vector<Part> pair{part("chip", 4e-9, .5), part("bell", 1e-6, 0),
                               part("foot", 7e-9, .7)};
  for (const char* const words : {"3 separate parts", "1 chip", "2 bell", "--only", "--multi"})
    check_refused([&] { return chosen_parts(pair, choice); }, words);
  choice.multi = true;
  CHECK(chosen_parts(pair, choice).size() == 3);
  const std::vector<Part> speck{part("bell", 1e-6, 0), part("speck", 9e-11, .5)};
  CHECK(chosen_parts(speck, choice).size() == 1);
}

TEST_CASE("one part is taken by its name or its number") {
  const std::vector<Part> parts{part("bell", 1e-6, 0), part("2", 1e-6, .5), part("foot", 1e-6, .7)};
  LoadChoice choice;
  choice.part = "foot";
  CHECK(chosen_parts(parts, choice) == std::vector<std::size_t>{2});
  choice.part = "3";
  CHECK(chosen_parts(parts, choice) == std::vector<std::size_t>{2});
  choice.part = "2"; // a name goes before a number
  CHECK(chosen_parts(parts, choice) == std::vector<std::size_t>{1});
  for (const char* const wrong : {"0", "4", "1.5", "horn", "-1"}) {
    choice.part = wrong;
    check_refused([&] { return chosen_parts(parts, choice); }, "1 bell");
  }
}

TEST_CASE("one flat opening is closed, two are not, a bent one is not") {
  const auto without = [](std::set<int> faces, double bend) {
    Triangles t = box_of_squares({1, 1, 1}, 4, [&](const Vec3& p) {
      return p + Vec3{0, 0, p.z > .99 ? bend * p.x * (1 - p.x) : 0};
    });
    std::size_t kept = 0;
    for (std::size_t i = 0; i < t.triangles.size(); ++i)
      if (!faces.contains(static_cast<int>(i / 32))) // two faces an axis, 32 triangles each
        t.triangles[kept++] = t.triangles[i];
    t.triangles.resize(kept);
    find_shells(t);
    return t;
  };
  Triangles open = without({5}, 0);
  const auto holes = close_holes(open, .05, .4);
  REQUIRE(holes.size() == 1);
  CHECK(holes[0].closed);
  CHECK(holes[0].flat_opening);
  CHECK_NOTHROW(close(open));
  CHECK(enclosed(open) == doctest::Approx(1).epsilon(1e-12));
  Triangles tube = without({0, 1}, 0);
  for (const Hole& h : close_holes(tube, .05, .4))
    CHECK(!h.closed);
  Triangles bent = without({5}, .5); // the rim rises by an eighth
  for (const Hole& h : close_holes(bent, .05, .4))
    CHECK(!h.closed);
}
