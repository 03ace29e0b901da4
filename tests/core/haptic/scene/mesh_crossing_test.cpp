#include "core/haptic/scene/triangle_mesh.hpp"

#include <doctest/doctest.h>

#include <array>
#include <cmath>
#include <optional>
#include <vector>

using namespace tactus::haptic;
using tactus::Vec3;

TEST_CASE("a motion through an edge meets exactly one triangle, from any direction") {
  // Ridges and valleys along y, at integer coordinates: whatever meets a valley's line meets the
  // triangles on both sides of it at the same fraction, to the last bit.
  constexpr std::uint32_t kColumns = 33;
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  for (std::uint32_t i = 0; i < kColumns; ++i)
    for (const double y : {0.0, 1.0})
      corners.push_back({static_cast<double>(i), y, i % 2 ? 1.0 : 0.0});
  for (std::uint32_t i = 0; i + 1 < kColumns; ++i) {
    const std::uint32_t a = 2 * i;
    triangles.push_back({a, a + 2, a + 1});
    triangles.push_back({a + 1, a + 2, a + 3});
  }
  const TriangleMesh mesh(corners, triangles);
  REQUIRE(mesh.size() == triangles.size());
  for (std::uint32_t i = 2; i + 2 < kColumns; i += 2) {
    CAPTURE(i);
    const Vec3 valley{static_cast<double>(i), 0.25, 0};
    std::optional<Vec3> normal;
    for (const double aside : {0.0, -0.5, 0.5, -2.0, 2.0, -8.0, 8.0})
      for (const double along : {0.0, -0.25, 0.25}) {
        const Vec3 motion{aside, along, 16};
        WorkLimit work;
        const auto hit = mesh.crossing(valley + motion, valley - motion, work);
        REQUIRE(hit);
        if (hit->fraction != 0.5) // a ridge came before
          continue;
        CHECK(hit->normal.z == doctest::Approx(std::sqrt(0.5)));
        CHECK(std::abs(hit->normal.x) == doctest::Approx(std::sqrt(0.5)));
        if (normal)
          CHECK(hit->normal.x == normal->x);
        normal = hit->normal;
      }
    CHECK(normal);
  }
}

TEST_CASE("of two triangles met at the same fraction the last one in the mesh's order counts") {
  const std::vector<Vec3> roof{{0, -0.01, 0},    {0, 0.01, 0},     {-0.01, 0, -0.01},
                               {0.01, 0, -0.01}, {-0.01, 0, 0.01}, {0.01, 0, 0.01}};
  const Triangle left{0, 1, 2}, right{0, 1, 3}, left_up{0, 1, 4}, right_up{0, 1, 5};
  for (const bool right_last : {false, true}) {
    const auto normal_of = [&](const Triangle& one, const Triangle& other, double radius) {
      const TriangleMesh mesh(roof, std::array{right_last ? one : other, right_last ? other : one});
      WorkLimit work;
      const Vec3 above{0, 0, 0.02}, below{0, 0, -0.02};
      const auto hit = radius > 0 ? mesh.crossing(radius, above, below, work)
                                  : mesh.crossing(above, below, work);
      REQUIRE(hit.has_value());
      return hit->normal.x;
    };
    CHECK((normal_of(left, right, 0) > 0) == right_last);          // a point on the ridge
    CHECK((normal_of(left_up, right_up, 2e-3) < 0) == right_last); // a sphere in the valley
  }
}

TEST_CASE("a mesh leaves out triangles without area and with missing corners") {
  const std::vector<Vec3> corners{{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0.02, 0, 0}};
  const std::vector<Triangle> triangles{{0, 1, 2}, {4, 1, 2}, {0, 4, 2}, {0, 1, 4},
                                        {9, 9, 9}, {0, 1, 3}, {1, 1, 2}};
  CHECK(TriangleMesh(corners, triangles).size() == 1);
}
