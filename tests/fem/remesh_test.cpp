// Remeshed triangle surfaces: the same body, better triangles.
#include "fem/mesh/remesh.hpp"

#include "fem/mesh/crossing.hpp"
#include "surfaces.hpp"

#include <algorithm>
#include <doctest/doctest.h>

using namespace tactus::fem;
using tactus::Vec3;

namespace {

double longest_edge(const Triangles& t) {
  double longest = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, length(t.corner(i, k) - t.corner(i, (k + 1) % 3)));
  return longest;
}

} // namespace

TEST_CASE("a bar of long triangles keeps its volume to the last digits in even ones") {
  const Vec3 size{.1, .011, .004};
  const Triangles even = remeshed(closed(box({}, size)), .003, .0003);
  CHECK(enclosed(even) == doctest::Approx(size.x * size.y * size.z).epsilon(1e-12));
  CHECK(even.triangles.size() > 500);
  CHECK(even.triangles.size() < 2000);
  CHECK(share_of_slivers(even, 20) < .02);
  CHECK(longest_edge(even) < .0045);
  CHECK(!crossing(even));
  Triangles again = even;
  CHECK_NOTHROW(close(again)); // each edge has its two triangles
  CHECK(again.shells == 1);
}

TEST_CASE("a fine ball becomes coarse within the distance allowed") {
  const double radius = .05, away = .0005;
  const Triangles fine = closed(sphere({}, radius, 60)), even = remeshed(fine, .008, away);
  CHECK(fine.triangles.size() > 14000);
  CHECK(even.triangles.size() < 3000);
  CHECK(share_of_slivers(even, 15) < .01);
  // Corners stay on the ball, so nothing lies farther inside than the middle of a long edge.
  for (const Vec3& p : even.points)
    CHECK(std::abs(length(p) - radius) < away);
  CHECK(std::abs(enclosed(even) / enclosed(fine) - 1) < 3 * away / radius);
  Triangles again = even;
  CHECK_NOTHROW(close(again));
}

TEST_CASE("a cavity is renewed with its body") {
  const TriangleSoup both = box({}, {.04, .04, .04}) + box({.01, .01, .01}, {.02, .02, .02});
  const auto bodies = separate_bodies(closed(both));
  REQUIRE(bodies.size() == 1);
  const Triangles even = remeshed(bodies[0], .005, .0005);
  CHECK(even.shells == 2);
  CHECK(enclosed(even) == doctest::Approx(64e-6 - 8e-6).epsilon(1e-12));
}

TEST_CASE("surfaces that cut each other are found, those that touch are not") {
  const TriangleSoup cube = box({}, {1, 1, 1});
  const auto crosses = [&](const Vec3& low) {
    return bool(crossing(surface(cube + box(low, {1, 1, 1}))));
  };
  CHECK(crosses({.4, .3, .7}));
  CHECK(!crosses({2, 0, 0}));
  CHECK(!crosses({1, .3, .2}));
  CHECK(!crossing(closed(cube)));
}
