// Surfaces as other people's programs write them: welded, closed, united, wrapped.
#include "fem/io/triangles.hpp"
#include "fem/mesh/crossing.hpp"
#include "fem/mesh/ears.hpp"
#include "fem/mesh/holes.hpp"
#include "fem/mesh/remesh.hpp"
#include "fem/mesh/resurface.hpp"
#include "fem/mesh/shells.hpp"
#include "fem/mesh/weld.hpp"

#include <cctype>
#include <doctest/doctest.h>
#include <numbers>
#include <numeric>
#include <random>

using namespace tactus::fem;

namespace {

using Corners = std::array<Vector3, 3>;
using TriangleSoup = std::vector<Corners>;

TriangleSoup box(const Vector3& low, const Vector3& size) {
  std::array<Vector3, 8> p;
  for (int i = 0; i < 8; ++i)
    p[static_cast<std::size_t>(i)] =
        low + Vector3{i % 2 * size.x, i / 2 % 2 * size.y, double(i / 4) * size.z};
  TriangleSoup out;
  for (const auto& [a, b, c] : std::vector<std::array<std::size_t, 3>>{{0, 2, 3},
                                                                       {0, 3, 1},
                                                                       {4, 5, 7},
                                                                       {4, 7, 6},
                                                                       {0, 1, 5},
                                                                       {0, 5, 4},
                                                                       {2, 6, 7},
                                                                       {2, 7, 3},
                                                                       {0, 4, 6},
                                                                       {0, 6, 2},
                                                                       {1, 3, 7},
                                                                       {1, 7, 5}})
    out.push_back({p[a], p[b], p[c]});
  return out;
}

TriangleSoup sphere(const Vector3& centre, double radius, int rings) {
  const auto at = [&](int i, int j) {
    const double a = std::numbers::pi * i / rings, b = std::numbers::pi * j / rings;
    return centre +
           radius * Vector3{std::sin(a) * std::cos(b), std::sin(a) * std::sin(b), std::cos(a)};
  };
  TriangleSoup out;
  for (int i = 0; i < rings; ++i)
    for (int j = 0; j < 2 * rings; ++j) {
      if (i > 0)
        out.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + 1 < rings)
        out.push_back({at(i, j + 1), at(i + 1, j), at(i + 1, j + 1)});
    }
  return out;
}

TriangleSoup operator+(TriangleSoup a, const TriangleSoup& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Every corner a point of its own, as an STL has them.
Triangles surface(const TriangleSoup& soup) {
  Triangles t;
  for (const Corners& c : soup) {
    const int n = static_cast<int>(t.points.size());
    t.points.insert(t.points.end(), c.begin(), c.end());
    t.triangles.push_back({n, n + 1, n + 2});
  }
  return t;
}

double enclosed(const Triangles& t) {
  double sum = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    sum += dot(t.corner(i, 0), cross(t.corner(i, 1), t.corner(i, 2))) / 6;
  return sum;
}

Triangles closed(const TriangleSoup& soup) {
  Triangles t = surface(soup);
  weld(t);
  close(t);
  return t;
}

} // namespace

TEST_CASE("corners that differ by rounding are one, thin features stay") {
  TriangleSoup cube = box({}, {.01, .01, .01});
  for (std::size_t i = 0; i < cube.size(); ++i)
    for (Vector3& p : cube[i])
      for (int k = 0; k < 3; ++k)
        if (p[k] == 0)
          p[k] = i % 2 ? -5.7e-20 : 1e-12;
  CHECK(closed(cube).points.size() == 8);
  // A sheet of 1e-5 of its length is a body, not a rounding error.
  const Triangles sheet = closed(box({}, {1, 1, 1e-5}));
  CHECK(sheet.points.size() == 8);
  CHECK(enclosed(sheet) == doctest::Approx(1e-5).epsilon(1e-9));
}

TEST_CASE("a corner on another triangle's edge cuts it") {
  TriangleSoup cube = box({}, {1, 1, 1});
  const Corners half = cube[2]; // of the top: in two at the middle of its first edge
  const Vector3 middle = .5 * (half[0] + half[1]);
  cube[2] = {half[0], middle, half[2]};
  cube.push_back({middle, half[1], half[2]});
  Triangles t = surface(cube);
  const Welded done = weld(t);
  CHECK(done.split == 1);
  REQUIRE_NOTHROW(close(t));
  CHECK(enclosed(t) == doctest::Approx(1));
}

TEST_CASE("a wall between stacked boxes goes, a triangle written twice stays once") {
  const TriangleSoup lower = box({}, {1, 1, 1}), upper = box({0, 0, 1}, {1, 1, 1});
  TriangleSoup stacked = lower + upper; // the wall is cut along the other diagonal in one of them
  const Triangles tower = closed(box({}, {1, 1, 1}) + [&] {
    TriangleSoup turned = upper;
    for (Corners& c : turned)
      for (Vector3& p : c)
        p.z = 2 - (p.z - 0) + 1; // mirrored at z = 1.5: same diagonals below
    for (Corners& c : turned)
      std::swap(c[0], c[1]);
    return turned;
  }());
  CHECK(enclosed(tower) == doctest::Approx(2));
  const Triangles doubled = closed(lower + TriangleSoup{lower[4], lower[5]});
  CHECK(doubled.triangles.size() == 12);
}

TEST_CASE("a fin on a cube is left out") {
  const TriangleSoup cube = box({}, {1, 1, 1});
  Triangles t = surface(cube + TriangleSoup{{cube[0][0], cube[0][1], {.5, .5, .5}}});
  CHECK(weld(t).fins == 1);
  close(t);
  CHECK(enclosed(t) == doctest::Approx(1));
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
  const Vector3 at = ball[400][0];
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
    TriangleSoup next = box({-size / 2, -size / 2, -size / 2}, {size, size, size});
    if (size == 3.)
      for (Corners& c : next)
        std::swap(c[0], c[1]);
    all = all + next;
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
  TriangleSoup inner = box({.3, .3, .3}, {.2, .2, .2});
  for (Corners& c : inner)
    std::swap(c[0], c[1]);
  Triangles hollow = surface(box({}, {1, 1, 1}) + inner + box({3, 0, 0}, {1, 1, 1}));
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
    for (Vector3& p : c)
      p = {.8 * p.x - .6 * p.z, p.y, .6 * p.x + .8 * p.z};
  const double both = .02 + .3 * .9 * .05 - .3 * .6 * .01;
  const Resurfaced made = united(closed(plates));
  CHECK(made.volume == doctest::Approx(both).epsilon(.01));
  CHECK(enclosed(separate_bodies(made.surface)[0]) == doctest::Approx(both).epsilon(.015));
}

TEST_CASE("a wrap closes holes, unites boxes and holds a soup of triangles") {
  TriangleSoup ball = sphere({}, 1, 40);
  for (const Vector3& at : {Vector3{1, 0, 0}, Vector3{0, 1, 0}, Vector3{-.6, -.6, .5}})
    std::erase_if(ball, [&](const Corners& c) { return length(c[0] - at) < .05; });
  const double round = 4 * std::numbers::pi / 3;
  const Resurfaced wrapped = shrink_wrapped(surface(ball), .25);
  CHECK(wrapped.volume == doctest::Approx(round).epsilon(.01));
  CHECK(separate_bodies(wrapped.surface).size() == 1);
  // Too small a gap leaves the inside open: only the sheet itself could be wrapped.
  CHECK_THROWS_AS(static_cast<void>(shrink_wrapped(surface(ball), .002)), InputError);
  // A gap is refused from 1.5 times the ball's diameter on, and the error says so.
  CHECK_THROWS_WITH_AS(static_cast<void>(shrink_wrapped(surface(ball), 3.1)),
                       doctest::Contains("a body of 2e+03 mm: expected 3e+03 mm at most"),
                       InputError);
  CHECK(shrink_wrapped(surface(ball), 2.9).volume == doctest::Approx(round).epsilon(.01));

  const TriangleSoup boxes = box({}, {1, 1, 1}) + box({.4, .3, .6}, {1, 1, 1});
  CHECK(shrink_wrapped(surface(boxes), .1).volume == doctest::Approx(2 - .168).epsilon(.01));

  std::mt19937 random(7); // each triangle shifted, turned and enlarged: nothing fits to anything
  std::uniform_real_distribution<double> noise(-.004, .004);
  TriangleSoup soup = sphere({}, 1, 30);
  for (Corners& c : soup) {
    const Vector3 shift{noise(random), noise(random), noise(random)};
    for (Vector3& p : c)
      p += shift;
    if (random() % 2)
      std::swap(c[0], c[1]);
  }
  const Resurfaced skin = shrink_wrapped(surface(soup), .12);
  CHECK(skin.volume == doctest::Approx(round).epsilon(.02));
  Triangles again = skin.surface;
  CHECK_NOTHROW(close(again));
}

TEST_CASE("ears of a concave polygon fill it once") {
  const std::vector<Vector3> comb{{0, 0, 1}, {5, 0, 1}, {5, 3, 1}, {4, 3, 1}, {4, 1, 1},
                                  {3, 1, 1}, {3, 3, 1}, {2, 3, 1}, {2, 1, 1}, {0, 1, 1}};
  double area = 0;
  for (const auto& [a, b, c] : clip_ears(comb)) {
    const auto p = [&](int i) { return comb[static_cast<std::size_t>(i)]; };
    const Vector3 n = cross(p(b) - p(a), p(c) - p(a));
    CHECK(n.z >= 0);
    area += n.z / 2;
  }
  CHECK(area == doctest::Approx(5 + 2 + 2));
}

TEST_CASE("polygons of a file are cut by their ears, in metres, by group") {
  const std::string u = "v 0 0 0\nv 3 0 0\nv 3 2 0\nv 2 2 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n";
  const Triangles t = triangles_of("a.OBJ", u + "o u\nf 1 2 3 4 5 6 7 8\no flap\nf 1 2 3\n", 2);
  REQUIRE(t.triangles.size() == 7);
  CHECK(t.groups == std::vector<std::string>{"u", "flap"});
  CHECK(t.group == std::vector<int>{0, 0, 0, 0, 0, 0, 1});
  CHECK(t.points[2] == Vector3{6, 4, 0});
  double area = 0;
  for (std::size_t i = 0; i < 6; ++i) {
    CHECK(t.normal(i).z > 0);
    area += t.normal(i).z / 2;
  }
  CHECK(area == doctest::Approx(4 * 5));
}

TEST_CASE("files of triangles are refused with path and place") {
  const auto refused = [&](const std::string& path, const std::string& bytes) {
    try {
      static_cast<void>(triangles_of(path, bytes, 1));
    } catch (const InputError& refusal) {
      return std::string(refusal.what());
    }
    return std::string();
  };
  const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0 # corner\nv 0 1 0\n";
  CHECK(refused("a.obj", square + "surf 0 1 0 1 1 2 3 4\nf 1 2 9\n") ==
        "a.obj line 5: \"surf\" is a free-form curve or surface, expected polygons (f): export the "
        "body as polygons, or as STEP");
  CHECK(refused("a.obj", square + "f 1 2 9\n") == "a.obj line 5: vertex 9 does not exist");
  CHECK(refused("a.stl", "cube") ==
        "a.stl is no STL file: it has 4 bytes and does not start with \"solid\"");
  std::string nan(84, ' ');
  nan.replace(80, 4, std::string("\1\0\0\0", 4));
  nan += std::string(50, '\xff');
  CHECK(refused("a.stl", nan) == "a.stl: triangle 1 has a corner that is no number");
  std::string face = "f";
  for (int i = 0; i < 4097; ++i)
    face += " 1";
  CHECK(refused("a.obj", square + face) ==
        "a.obj line 5: a face with 4097 corners, expected 3 to 4096");
}
