// Remeshed triangle surfaces: the same body, better triangles.
#include "fem/mesh/remesh.hpp"

#include "fem/mesh/crossing.hpp"
#include "fem/mesh/shells.hpp"

#include <algorithm>
#include <doctest/doctest.h>
#include <numbers>

using namespace tactus::fem;

namespace {

/// A box with its corners in the usual order: x fastest, z slowest.
Triangles box(const Vector3& size, const Vector3& low = {}) {
  Triangles t;
  for (int i = 0; i < 8; ++i)
    t.points.push_back(low + Vector3{i % 2 * size.x, i / 2 % 2 * size.y, double(i / 4) * size.z});
  t.triangles = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};
  t.shell.assign(12, 0);
  t.shells = 1;
  return t;
}

/// A ball of rings and meridians: slivers at its poles.
Triangles ball(double radius, int rings, int meridians) {
  Triangles t;
  t.points.push_back({0, 0, radius});
  for (int i = 1; i < rings; ++i)
    for (int j = 0; j < meridians; ++j) {
      const double a = std::numbers::pi * i / rings, b = 2 * std::numbers::pi * j / meridians;
      t.points.push_back({radius * std::sin(a) * std::cos(b), radius * std::sin(a) * std::sin(b),
                          radius * std::cos(a)});
    }
  t.points.push_back({0, 0, -radius});
  const auto at = [&](int i, int j) { return 1 + (i - 1) * meridians + j % meridians; };
  const int last = static_cast<int>(t.points.size()) - 1;
  for (int j = 0; j < meridians; ++j) {
    t.triangles.push_back({0, at(1, j), at(1, j + 1)});
    t.triangles.push_back({last, at(rings - 1, j + 1), at(rings - 1, j)});
    for (int i = 1; i + 1 < rings; ++i) {
      t.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      t.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  t.shell.assign(t.triangles.size(), 0);
  t.shells = 1;
  return t;
}

double enclosed(const Triangles& t) {
  double sum = 0;
  for (const auto& [a, b, c] : t.triangles)
    sum +=
        dot(t.points[static_cast<std::size_t>(a)],
            cross(t.points[static_cast<std::size_t>(b)], t.points[static_cast<std::size_t>(c)])) /
        6;
  return sum;
}

double longest_edge(const Triangles& t) {
  double longest = 0;
  for (const auto& c : t.triangles)
    for (std::size_t k = 0; k < 3; ++k)
      longest = std::max(longest, length(t.points[static_cast<std::size_t>(c[k])] -
                                         t.points[static_cast<std::size_t>(c[(k + 1) % 3])]));
  return longest;
}

} // namespace

TEST_CASE("a bar of long triangles keeps its volume to the last digits in even ones") {
  const Vector3 size{.1, .011, .004};
  const Triangles even = remeshed(box(size), .003, .0003);
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
  const Triangles fine = ball(radius, 60, 120), even = remeshed(fine, .008, away);
  CHECK(fine.triangles.size() > 14000);
  CHECK(even.triangles.size() < 3000);
  CHECK(share_of_slivers(even, 15) < .01);
  // Corners stay on the ball, so nothing lies farther inside than the middle of a long edge.
  for (const Vector3& p : even.points)
    CHECK(std::abs(length(p) - radius) < away);
  CHECK(std::abs(enclosed(even) / enclosed(fine) - 1) < 3 * away / radius);
  Triangles again = even;
  CHECK_NOTHROW(close(again));
}

TEST_CASE("a cavity is renewed with its body") {
  Triangles both = box({.04, .04, .04});
  const Triangles inner = box({.02, .02, .02}, {.01, .01, .01});
  for (const Vector3& p : inner.points)
    both.points.push_back(p);
  for (const auto& [a, b, c] : inner.triangles) {
    both.triangles.push_back({a + 8, c + 8, b + 8});
    both.shell.push_back(1);
  }
  both.shells = 2;
  const Triangles even = remeshed(both, .005, .0005);
  CHECK(even.shells == 2);
  CHECK(enclosed(even) == doctest::Approx(64e-6 - 8e-6).epsilon(1e-12));
}

TEST_CASE("surfaces that cut each other are found, those that touch are not") {
  const auto with = [](const Vector3& low) {
    Triangles t = box({1, 1, 1});
    const Triangles other = box({1, 1, 1}, low);
    t.points.insert(t.points.end(), other.points.begin(), other.points.end());
    for (const auto& [a, b, c] : other.triangles)
      t.triangles.push_back({a + 8, b + 8, c + 8});
    return t;
  };
  CHECK(crossing(with({.4, .3, .7})));
  CHECK(!crossing(with({2, 0, 0})));
  CHECK(!crossing(with({1, .3, .2})));
  CHECK(!crossing(box({1, 1, 1})));
}
