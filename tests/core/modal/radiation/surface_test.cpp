// Surfaces of triangles: the nearest place by search through all of them, directions along them,
// integrals over them by closed forms, and their nodes.
#include "core/geometry/surface.hpp"
#include "core/modal/radiation/surface_quadrature.hpp"
#include "tests/core/modal/rig.hpp"

#include <doctest/doctest.h>

using namespace tactus::modal;
using namespace tactus::test;
using tactus::Vec3;

namespace {

using Triangle = std::array<std::int32_t, 3>;

/// Two triangles that meet at an angle along the y axis, the first in the x-y plane.
struct Fold {
  explicit Fold(double degrees)
      : vertex{{0, 0, 0},
               {0, 1, 0},
               {-1, .5, 0},
               {std::cos(degrees / 57.29577951), .5, std::sin(degrees / 57.29577951)}},
        triangle{Triangle{0, 1, 2}, Triangle{0, 3, 1}} {
    surface.build(vertex, triangle);
  }
  std::vector<Vec3> vertex;
  std::vector<Triangle> triangle;
  Surface surface;
};

} // namespace

TEST_CASE("the nearest point of a surface is the nearest of all its triangles'") {
  std::mt19937 random(11);
  std::uniform_real_distribution<> plain(-1, 1);
  const auto point = [&](double size) {
    return Vec3{size * plain(random), size * plain(random), size * plain(random)};
  };
  for (const std::size_t count : {1UL, 4UL, 5UL, 9UL, 100UL, 1000UL}) {
    std::vector<Vec3> vertex;
    std::vector<Triangle> triangle;
    const std::vector<Triangle> alone{Triangle{0, 1, 2}};
    std::vector<Surface> single(count);
    Vec3 low{9, 9, 9}, high{-9, -9, -9};
    for (std::size_t t = 0; t < count; ++t) {
      const Vec3 centre = point(1);
      const auto first = static_cast<std::int32_t>(vertex.size());
      for (int i = 0; i < 3; ++i) {
        vertex.push_back(centre + point(.2));
        for (int axis = 0; axis < 3; ++axis) {
          low[axis] = std::min(low[axis], vertex.back()[axis]);
          high[axis] = std::max(high[axis], vertex.back()[axis]);
        }
      }
      triangle.push_back({first, first + 1, first + 2});
      single[t].build(std::span(vertex).last(3), alone);
    }
    Surface surface;
    surface.build(vertex, triangle);
    REQUIRE(surface.triangles() == count);
    CHECK(surface.lowest() == low);
    CHECK(surface.highest() == high);
    CHECK(surface.diagonal() == approx(norm(high - low)));
    for (int trial = 0; trial < 100; ++trial) {
      const Vec3 p = point(trial % 3 ? 1 : 4);
      double best = 1e9;
      for (const Surface& one : single) {
        const SurfacePoint q = one.nearest(p);
        best = std::min(best, q.distance);
        // That of one triangle is the nearest if no corner lies further towards p.
        for (const Vec3& corner : one.corners(0))
          CHECK(dot(p - q.position, corner - q.position) < 1e-12);
      }
      const SurfacePoint found = surface.nearest(p);
      CHECK(found.distance == approx(best).epsilon(1e-9));
      CHECK(norm(found.position - p) == approx(best).epsilon(1e-9));
      const auto& c = surface.corners(found.triangle);
      Vec3 blend{};
      for (std::size_t i = 0; i < 3; ++i) {
        CHECK(found.weight[i] >= -1e-12);
        blend += found.weight[i] * c[i];
      }
      CHECK(found.weight[0] + found.weight[1] + found.weight[2] == approx(1).epsilon(1e-12));
      CHECK(norm(blend - found.position) < 1e-12);
      const Vec3 normal = cross(c[1] - c[0], c[2] - c[0]);
      CHECK(norm(found.normal - normal * (1 / norm(normal))) < 1e-9);
    }
    const std::size_t t = count / 2;
    const auto& c = surface.corners(t);
    const SurfacePoint on = surface.on(t, .2, .3);
    CHECK(on.triangle == t);
    CHECK(norm(on.position - (.5 * c[0] + .2 * c[1] + .3 * c[2])) < 1e-12);
    CHECK(dot(on.normal, cross(c[1] - c[0], c[2] - c[0])) > 0);
  }
}

TEST_CASE("of equally near points that of the triangle of the lower number is taken") {
  const Fold fold(0);
  for (const double y : {0., .25, 1.}) {
    CHECK(fold.surface.nearest({0, y, .3}).triangle == 0);
    CHECK(fold.surface.nearest({0, y, 0}).distance == 0);
  }
  CHECK(fold.surface.nearest({.1, .5, 0}).triangle == 1);
}

TEST_CASE("a direction along a surface is the nearest to the one wanted") {
  const Vec3 up{0, 0, 1};
  CHECK(norm(along_surface(up, {3, 4, 0}) - Vec3{.6, .8, 0}) < 1e-12);
  // A facet's slope of less than 20 degrees is the wanted direction's own business.
  const Vec3 slight{1, 0, .3}, steep{1, 0, .5};
  CHECK(norm(along_surface(up, slight) - slight * (1 / norm(slight))) < 1e-12);
  CHECK(norm(along_surface(up, steep) - Vec3{1, 0, 0}) < 1e-12);
  const double edge = std::tan(20 / 57.29577951);
  CHECK(along_surface(up, {1, 0, .995 * edge}).z > .3);
  CHECK(along_surface(up, {1, 0, 1.005 * edge}).z == 0);
  CHECK(norm(along_surface(up, {0, -2, -20}) - Vec3{0, -1, 0}) < 1e-12);
  // Along the normal, and for nothing at all: x, and where that is the normal, y.
  CHECK(along_surface(up, {0, 0, 5}) == Vec3{1, 0, 0});
  CHECK(along_surface(up, {0, 0, 0}) == Vec3{1, 0, 0});
  CHECK(along_surface({1, 0, 0}, {2, 0, 0}) == Vec3{0, 1, 0});
  CHECK(norm(along_surface({1, 0, 0}, {2, 0, .01}) - Vec3{0, 0, 1}) < 1e-12);
}

TEST_CASE("integrals over a triangle are exact to the degree of their rule") {
  const std::vector<Vec3> vertex{{0, 0, 0}, {1e-2, 0, 0}, {2e-3, 8e-3, 0}};
  const std::vector<Triangle> triangle{Triangle{0, 1, 2}};
  Surface surface;
  surface.build(vertex, triangle);
  const std::size_t all = 0;
  const double longest = std::hypot(8e-3, 8e-3); // of 10, 8.2 and 11.3 mm
  // Moments of the weights: the integral of a^i b^j over a triangle is 2 A i! j!/(i + j + 2)!.
  const auto factorial = [](int n) { return std::tgamma(n + 1.); };
  struct Case {
    double distance, turn; // over the longest edge, rad along it
    std::size_t points;    // 0: arcs of equal distance
    int degree;
  };
  for (const Case& c : {Case{100, .24, 1, 1},
                        {100, .26, 3, 2},
                        {100, .79, 3, 2},
                        {100, .81, 7, 5},
                        {100, 1.9, 7, 5},
                        {100, 2.1, 0, 1},
                        {12, .2, 1, 1},
                        {8, .2, 3, 2},
                        {5, .2, 3, 2},
                        {3, .2, 7, 5},
                        {2, .2, 7, 5},
                        {.8, .2, 0, 1}}) {
    CAPTURE(c.distance);
    CAPTURE(c.turn);
    const double size = 2, area = .5 * 1e-2 * 8e-3 * size * size;
    const Vec3 listener = size * (vertex[2] + c.distance * (vertex[2] - vertex[1]));
    const auto sources =
        surface_sources(surface, {&all, 1}, listener, size, c.turn / (longest * size), 1e-4);
    if (c.points > 0)
      CHECK(sources.size() == c.points);
    for (int i = 0; i <= c.degree; ++i)
      for (int j = 0; i + j <= c.degree; ++j) {
        double sum = 0;
        for (const SurfaceSource& s : sources)
          sum += s.area_m2 * std::pow(static_cast<double>(s.weight[1]), i) *
                 std::pow(static_cast<double>(s.weight[2]), j);
        CAPTURE(i);
        CAPTURE(j);
        CHECK(sum == approx(2 * area * factorial(i) * factorial(j) / factorial(i + j + 2))
                         .epsilon(c.points > 0 ? 1e-5 : 1e-3));
      }
    for (const SurfaceSource& s : sources) {
      Vec3 at{};
      for (std::size_t i = 0; i < 3; ++i)
        at += static_cast<double>(s.weight[i]) * size * vertex[i];
      if (c.points > 0)
        CHECK(s.distance_m == approx(norm(listener - at)).epsilon(1e-6));
    }
  }
  for (const SurfaceSource& s : surface_sources(surface, {&all, 1}, {4e-3, 3e-3, 0}, 1, 1, .5))
    CHECK(s.distance_m == .5);
}

TEST_CASE("a large or near triangle sounds as its parts, wherever the listener is") {
  const std::vector<Vec3> vertex{{.01, -.02, .03}, {.13, .01, .02}, {.04, .08, .05}};
  const std::vector<Triangle> triangle{Triangle{0, 1, 2}};
  Surface surface;
  surface.build(vertex, triangle);
  const std::size_t all = 0;
  const Vec3 twice = cross(vertex[1] - vertex[0], vertex[2] - vertex[0]);
  const Vec3 normal = twice * (1 / norm(twice));
  struct Listener {
    double b, c, height; // weights of the second and third corner at the listener's foot; m
  };
  for (const Listener& from : {Listener{.3, .3, .05},
                               {.3, .3, -.002},
                               {.4, .2, 0},
                               {.5, 0, .03},
                               {.5, 0, 0},
                               {0, 0, .02},
                               {1, 0, 1e-6},
                               {-.4, .6, .01},
                               {1.5, 1.2, .1},
                               {-2, 3, 0},
                               {8, -3, .5},
                               {.2, .7, 2}}) {
    CAPTURE(from.b);
    CAPTURE(from.height);
    const Vec3 listener = vertex[0] + from.b * (vertex[1] - vertex[0]) +
                          from.c * (vertex[2] - vertex[0]) + from.height * normal;
    for (const double wavenumber : {40., 400.}) {
      std::array<Complex, 3> found{}, parts{};
      double size = 0; // the integral of 1/d
      for (const SurfaceSource& s :
           surface_sources(surface, {&all, 1}, listener, 1, wavenumber, 1e-6))
        for (std::size_t j = 0; j < 3; ++j)
          found[j] += static_cast<double>(s.weight[j]) * s.area_m2 / s.distance_m *
                      tactus::math::polar(1.0, -wavenumber * s.distance_m);
      // Middles of small triangles, upright and turned; those at the listener have little area.
      constexpr int kRows = 400;
      for (int i = 0; i < kRows; ++i)
        for (int j = 0; i + j < kRows; ++j)
          for (const double third : {1. / 3, 2. / 3}) {
            const double b = (i + third) / kRows, c = (j + third) / kRows;
            if (b + c > 1)
              continue;
            const Vec3 at = vertex[0] + b * (vertex[1] - vertex[0]) + c * (vertex[2] - vertex[0]);
            const double distance = norm(at - listener), area = .5 * norm(twice) / kRows / kRows;
            size += area / distance;
            const Complex share =
                area / distance * tactus::math::polar(1.0, -wavenumber * distance);
            parts[0] += (1 - b - c) * share;
            parts[1] += b * share;
            parts[2] += c * share;
          }
      for (std::size_t j = 0; j < 3; ++j) {
        CAPTURE(j);
        CHECK(abs(found[j] - parts[j]) < 1e-3 * size);
      }
    }
  }
}

namespace {

/// Sources of a square of two triangles, no more than memory is for, with all of its area.
std::vector<SurfaceSource> square_sources(double size) {
  CAPTURE(size);
  const std::vector<Vec3> vertex{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  const std::vector<Triangle> triangle{Triangle{0, 1, 2}, Triangle{0, 2, 3}};
  Surface surface;
  surface.build(vertex, triangle);
  const std::array<std::size_t, 2> all{0, 1};
  auto sources = surface_sources(surface, all, {3.1, 4.3, 1}, size, 400, 1e-4);
  CHECK(sources.size() <= kMaxSurfaceSources);
  double area = 0, along = 0;
  for (const SurfaceSource& s : sources) {
    area += s.area_m2;
    along += s.area_m2 * static_cast<double>(s.weight[1]); // a third of each triangle's
  }
  CHECK(area == approx(size * size).epsilon(1e-9));
  CHECK(along == approx(size * size / 3).epsilon(1e-5));
  return sources;
}

} // namespace

TEST_CASE("a plate of 10 m that may not be resolved to 20 kHz keeps its pressure at 2 kHz") {
  constexpr double kSize = 10, kWavenumber = 36.6; // m; 2 kHz in air
  Complex sum = 0, plain = 0;
  for (const SurfaceSource& s : square_sources(kSize))
    sum += s.area_m2 / s.distance_m * tactus::math::polar(1.0, -kWavenumber * s.distance_m);
  // Rayleigh's integral by squares of 20 mm, Gauss's two points a side in each.
  constexpr int kSquares = 500;
  constexpr double kSide = kSize / kSquares, kGauss = 0.5 / std::numbers::sqrt3;
  const auto at = [](int n) { return kSide * (n / 2 + 0.5 + (n % 2 == 0 ? -kGauss : kGauss)); };
  for (int i = 0; i < 2 * kSquares; ++i)
    for (int j = 0; j < 2 * kSquares; ++j) {
      const double distance = norm(Vec3{at(i), at(j), 0} - Vec3{3.1, 4.3, 1});
      plain += 0.25 * kSide * kSide / distance * tactus::math::polar(1.0, -kWavenumber * distance);
    }
  CHECK(abs(sum - plain) < 1e-3 * abs(plain)); // 0.01 dB
}

TEST_CASE("a surface of 30 m or 10 km has no more sources than memory is for, and all its area" *
          doctest::test_suite("slow")) {
  static_cast<void>(square_sources(30));
  static_cast<void>(square_sources(1e4));
}

TEST_CASE("a vertex is one node where its surface turns by less than 30 degrees, else one a side") {
  for (const double degrees : {0., 10., 29., 31., 90., 170.}) {
    CAPTURE(degrees);
    const Fold fold(degrees);
    const SurfaceNodes nodes = surface_nodes(fold.surface, fold.triangle, 4);
    const bool smooth = degrees < 30;
    CHECK(nodes.vertex.size() == (smooth ? 4 : 6));
    CHECK((nodes.triangle_nodes[0][0] == nodes.triangle_nodes[1][0]) == smooth);
    CHECK((nodes.triangle_nodes[0][1] == nodes.triangle_nodes[1][2]) == smooth);
    for (std::size_t t = 0; t < 2; ++t)
      for (std::size_t i = 0; i < 3; ++i) {
        const std::uint32_t node = nodes.triangle_nodes[t][i];
        CHECK(nodes.vertex[node] == static_cast<std::uint32_t>(fold.triangle[t][i]));
        CHECK(norm(nodes.normal[node]) == approx(1));
        const auto& c = fold.surface.corners(t);
        const Vec3 normal = cross(c[1] - c[0], c[2] - c[0]);
        CHECK(dot(nodes.normal[node], normal) > .96 * norm(normal));
      }
  }
}
