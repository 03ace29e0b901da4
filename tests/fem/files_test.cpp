// Surfaces as other people's programs write them: welded, closed, united, wrapped.
#include "fem/io/triangles.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/ears.hpp"
#include "fem/mesh/holes.hpp"
#include "fem/mesh/remesh.hpp"
#include "fem/mesh/resurface.hpp"
#include "solve.hpp"
#include "surfaces.hpp"

#include <random>

using namespace tactus::fem;
using tactus::Vec3;

TEST_CASE("corners that differ by rounding are one, thin features stay") {
  TriangleSoup cube = box({}, {.01, .01, .01});
  for (std::size_t i = 0; i < cube.size(); ++i)
    for (Vec3& p : cube[i])
      for (int k = 0; k < 3; ++k)
        if (p[k] == 0)
          p[k] = i % 2 ? -5.7e-20 : 1e-12;
  CHECK(closed(cube).points.size() == 8);
  // A sheet of 1e-5 of its length is a body, not a rounding error.
  const Triangles sheet = closed(box({}, {1, 1, 1e-5}));
  CHECK(sheet.points.size() == 8);
  CHECK(enclosed(sheet) == doctest::Approx(1e-5).epsilon(1e-9));
}

TEST_CASE("a corner on another triangle's edge cuts it, a fin is left out, a copy too") {
  const TriangleSoup cube = box({}, {1, 1, 1});
  TriangleSoup split = cube;
  const auto [a, b, c] = cube[2]; // of the top: in two at the middle of its first edge
  split[2] = {a, .5 * (a + b), c};
  Triangles t = surface(split + TriangleSoup{{.5 * (a + b), b, c}});
  CHECK(weld(t).split == 1);
  REQUIRE_NOTHROW(close(t));
  CHECK(enclosed(t) == doctest::Approx(1));
  t = surface(cube + TriangleSoup{{cube[0][0], cube[0][1], {.5, .5, .5}}});
  CHECK(weld(t).fins == 1);
  close(t);
  CHECK(enclosed(t) == doctest::Approx(1));
  CHECK(closed(cube + TriangleSoup{cube[4], cube[5]}).triangles.size() == 12);
}

TEST_CASE("a wall between stacked boxes goes") {
  TriangleSoup upper = box({}, {1, 1, 1}); // mirrored: the same diagonals in the wall
  for (Corners& c : upper)
    for (Vec3& p : c)
      p.z = 2 - p.z;
  CHECK(enclosed(closed(box({}, {1, 1, 1}) + turned(upper))) == doctest::Approx(2));
}

TEST_CASE("a wall whose triangles differ on its two sides goes too") {
  TriangleSoup between = box({1, 0, 0}, {1, 1, 1}); // mirrored: the diagonals in the walls cross
  for (Corners& c : between)
    for (Vec3& p : c)
      p.y = 1 - p.y;
  Triangles t = closed(box({}, {1, 1, 1}) + turned(between) + box({2, 0, 0}, {1, 1, 1}));
  CHECK(drop_flat_shells(t, 1e-5) == 2);
  CHECK(enclosed(t) == doctest::Approx(3));
  CHECK_FALSE(crossing(t));
}

TEST_CASE("a box within a box that shares its sides adds nothing") {
  const Triangles both = closed(box({}, {1, 1, 1}) + box({}, {.5, 1, 1}));
  CHECK(united(both).volume == doctest::Approx(1).epsilon(.01));
  for (const Triangles& body : separate_bodies(both))
    CHECK(enclosed(body) > 0);
}

TEST_CASE("bars along the grid that cross or lap at a corner are their union") {
  for (const auto& [other, size, whole] :
       {std::tuple{Vec3{.35, -.35, 0}, Vec3{.1, .8, .1}, .015}, {Vec3{}, Vec3{.1, .6, .1}, .013}}) {
    const Triangles bars = closed(box({}, {.8, .1, .1}) + box(other, size));
    const Resurfaced made = united(bars);
    CHECK(made.volume == doctest::Approx(whole).epsilon(.004));
    CHECK(made.inverted == 0);
    CHECK(enclosed(separate_bodies(made.surface)[0]) == doctest::Approx(whole).epsilon(.006));
  }
}

TEST_CASE("two cubes that meet at an edge are two shells") {
  const Triangles t = closed(box({}, {1, 1, 1}) + box({1, 1, 0}, {1, 1, 1}));
  CHECK(t.shells == 2);
  for (const double v : shell_volumes(t))
    CHECK(v == doctest::Approx(1));
  CHECK(shells_touch(t, 1e-9));
}

TEST_CASE("small holes are closed and told with place and width, large ones are left") {
  TriangleSoup ball = sphere({.1, .2, .3}, 1, 20);
  const Vec3 at = ball[400][0];
  std::erase_if(ball, [&](const Corners& c) {
    return length(c[0] - at) < .2 && length(c[1] - at) < .2 && length(c[2] - at) < .2;
  });
  Triangles t = surface(ball);
  weld(t);
  find_shells(t);
  CHECK(!open_edge_sentence(t).empty());
  Triangles strict = t;
  CHECK_FALSE(close_holes(strict, 1e-4, .4).at(0).closed);
  CHECK(!open_edge_sentence(strict).empty());
  const auto holes = close_holes(t, .05, .4);
  REQUIRE(holes.size() == 1);
  CHECK(holes[0].closed);
  CHECK(length(holes[0].centre - at) < .05);
  CHECK(holes[0].extent > .2);
  CHECK(holes[0].extent < .5);
  REQUIRE_NOTHROW(close(t));
  CHECK(enclosed(t) == doctest::Approx(4.18879).epsilon(.02));
}

TEST_CASE("nested shells are cavity and body by turns, whatever way they look") {
  TriangleSoup all;
  for (const double size : {4., 3., 2., 1.}) {
    const TriangleSoup next = box(-size / 2 * Vec3{1, 1, 1}, size * Vec3{1, 1, 1});
    all = all + (size == 3. ? turned(next) : next);
  }
  const auto bodies = separate_bodies(closed(all));
  REQUIRE(bodies.size() == 2);
  CHECK(enclosed(bodies[0]) == doctest::Approx(64 - 27));
  CHECK(enclosed(bodies[1]) == doctest::Approx(8 - 1));
  CHECK(bodies[0].shells == 2);
}

TEST_CASE("overlapping and touching boxes become their union, sharp edges and all") {
  // 1 + 1 - overlap, faces not on the grid's planes, one pair rotated.
  const Triangles cross_wise = closed(box({}, {1, 1, 1}) + box({.4, .3, .6}, {1, 1, 1}));
  const double both = 2 - .6 * .7 * .4;
  const Resurfaced made = united(cross_wise);
  CHECK(made.volume == doctest::Approx(both).epsilon(.005));
  CHECK(made.inverted == 0);
  CHECK(std::abs(made.volume_change) < .005);
  CHECK(separate_bodies(made.surface).size() == 1);
  CHECK(enclosed(separate_bodies(made.surface)[0]) == doctest::Approx(both).epsilon(.003));
  CHECK_FALSE(crossing(remeshed(made.surface, .1, .001)));
  const Triangles face_to_face = closed(box({}, {1, 1, 1}) + box({1, .25, .3}, {.5, .5, .5}));
  const auto joined = separate_bodies(united(face_to_face).surface);
  REQUIRE(joined.size() == 1);
  CHECK(enclosed(joined[0]) == doctest::Approx(1.125).epsilon(.003));
  // A cavity stays one, and a body apart stays apart.
  Triangles hollow = surface(box({}, {1, 1, 1}) + turned(box({.3, .3, .3}, {.2, .2, .2})) +
                             box({3, 0, 0}, {1, 1, 1}));
  weld(hollow);
  find_shells(hollow);
  for (std::size_t i = 0; i < hollow.triangles.size(); ++i)
    if (hollow.shell[i] == 1)
      std::swap(hollow.triangles[i][0], hollow.triangles[i][1]);
  const auto difference = separate_bodies(united(hollow).surface);
  REQUIRE(difference.size() == 2);
  CHECK(enclosed(difference[0]) + enclosed(difference[1]) ==
        doctest::Approx(2 - .008).epsilon(.003));
}

TEST_CASE("a rotated plate thinner than the grid's default step keeps its volume") {
  TriangleSoup plates = box({0, 0, 0}, {1, 1, .02}) + box({.4, -.3, .01}, {.3, .9, .05});
  for (Corners& c : plates)
    for (Vec3& p : c)
      p = {.8 * p.x - .6 * p.z, p.y, .6 * p.x + .8 * p.z};
  const double both = .02 + .3 * .9 * .05 - .3 * .6 * .01;
  const Resurfaced made = united(closed(plates));
  CHECK(made.volume == doctest::Approx(both).epsilon(.01));
  CHECK(enclosed(separate_bodies(made.surface)[0]) == doctest::Approx(both).epsilon(.015));
}

TEST_CASE("a wrap closes holes; a gap as large as the body is refused") {
  TriangleSoup ball = sphere({}, 1, 20);
  for (const Vec3& at : {Vec3{1, 0, 0}, Vec3{-.6, -.6, .5}})
    std::erase_if(ball, [&](const Corners& c) { return length(c[0] - at) < .1; });
  const double round = 4 * std::numbers::pi / 3;
  const Resurfaced wrapped = shrink_wrapped(surface(ball), .8);
  CHECK(wrapped.volume == doctest::Approx(round).epsilon(.02));
  CHECK(separate_bodies(wrapped.surface).size() == 1);
  // Half of the hole's width lets the ball in: only the sheet is left.
  check_refused([&] { return shrink_wrapped(surface(ball), .1); }, "enclose nothing at that gap");
  // A gap is refused from 1.5 times the ball's diameter on, and the error says so.
  check_refused([&] { return shrink_wrapped(surface(ball), 3.1); },
                "a body of 2e+03 mm: expected at most 3e+03 mm");
  CHECK(shrink_wrapped(surface(ball), 2.9).volume == doctest::Approx(round).epsilon(.02));
}

TEST_CASE("a wrap unites boxes, holds a soup of triangles, and needs a gap wider than the holes" *
          doctest::test_suite("slow")) {
  TriangleSoup ball = sphere({}, 1, 40);
  std::erase_if(ball, [&](const Corners& c) { return length(c[0] - Vec3{1, 0, 0}) < .05; });
  // Too small a gap leaves the inside open: only the sheet itself could be wrapped.
  CHECK_THROWS_AS((void)shrink_wrapped(surface(ball), .002), InputError);
  std::mt19937 random(7); // each triangle shifted and turned: nothing fits to anything
  std::uniform_real_distribution<double> noise(-.004, .004);
  TriangleSoup soup = sphere({}, 1, 30);
  for (Corners& c : soup) {
    const Vec3 shift{noise(random), noise(random), noise(random)};
    for (Vec3& p : c)
      p += shift;
    if (random() % 2)
      std::swap(c[0], c[1]);
  }
  const TriangleSoup boxes = box({}, {1, 1, 1}) + box({.4, .3, .6}, {1, 1, 1});
  CHECK(shrink_wrapped(surface(boxes), .1).volume == doctest::Approx(2 - .168).epsilon(.01));
  Resurfaced skin = shrink_wrapped(surface(soup), .12);
  CHECK(skin.volume == doctest::Approx(4 * std::numbers::pi / 3).epsilon(.02));
  CHECK_NOTHROW(close(skin.surface));
}

TEST_CASE("polygons of a file are cut by their ears, in metres, by group") {
  const std::string u = "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  const Triangles t = triangles_of("a.OBJ", u + "o u\nf 1 2 3 4 5 6 7 8\no flap\nf 1 2 3\n", 2);
  REQUIRE(t.triangles.size() == 7);
  CHECK(t.groups == std::vector<std::string>{"u", "flap"});
  CHECK(t.group == std::vector<int>{0, 0, 0, 0, 0, 0, 1});
  CHECK(t.points[2] == Vec3{6, 4, 0});
  double area = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(t.normal(i).z > 0);
    area += t.normal(i).z / 2;
  }
  CHECK(area == doctest::Approx(4 * 5));
}

TEST_CASE("files of triangles are refused with path and place") {
  const auto refused = [](const std::string& path, const std::string& bytes,
                          const std::string& words) {
    check_refused([&] { return triangles_of(path, bytes, 1); }, path + words);
  };
  refused(
      "a.obj", "v 0 0 0\nsurf 0 1 0 1 1 2 3 4\nf 1 2 9\n",
      " line 2: \"surf\" is a free-form curve or surface, expected polygons (f): export the body "
      "as polygons, or as STEP");
  refused("a.stl", "cube", " is not an STL file: it has 4 bytes and does not start with \"solid\"");
  std::string nan(84, ' ');
  nan.replace(80, 4, std::string("\1\0\0\0", 4));
  refused("a.stl", nan + std::string(50, '\xff'),
          ": triangle 1 has a corner that is not a finite number");
  std::string face = "f";
  for (int i = 0; i < 4097; ++i)
    face += " 1";
  refused("a.obj", "v 0 0 0\n" + face, " line 2: a face with 4097 corners, expected 3 to 4096");
}
