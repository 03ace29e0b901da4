#pragma once

#include "core/haptic/scene/shape.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

/// Meshes for tests.
namespace tactus::haptic::test {

/// A square of that side in the plane z = 0, centred, cells x cells squares of two triangles.
inline MeshSurface flat_mesh(std::uint32_t cells, double side_m) {
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      corners.push_back({side_m * (static_cast<double>(i) / cells - 0.5),
                         side_m * (static_cast<double>(j) / cells - 0.5), 0});
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  return {std::make_shared<const TriangleMesh>(corners, triangles)};
}

/// Corners on a sphere by longitude and latitude: 2 around (along - 1) triangles.
inline MeshSurface mesh_sphere(double radius_m, std::uint32_t around, std::uint32_t along) {
  std::vector<Vec3> corners{{0, 0, radius_m}};
  for (std::uint32_t j = 1; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double latitude = std::numbers::pi * j / along,
                   longitude = 2 * std::numbers::pi * i / around;
      corners.push_back({radius_m * std::sin(latitude) * std::cos(longitude),
                         radius_m * std::sin(latitude) * std::sin(longitude),
                         radius_m * std::cos(latitude)});
    }
  const auto last = static_cast<std::uint32_t>(corners.size());
  corners.push_back({0, 0, -radius_m});
  std::vector<Triangle> triangles;
  const auto at = [around](std::uint32_t j, std::uint32_t i) {
    return 1 + j * around + i % around;
  };
  for (std::uint32_t i = 0; i < around; ++i) {
    triangles.push_back({0, at(0, i), at(0, i + 1)});
    triangles.push_back({last, at(along - 2, i + 1), at(along - 2, i)});
    for (std::uint32_t j = 0; j + 2 < along; ++j) {
      triangles.push_back({at(j, i), at(j + 1, i), at(j + 1, i + 1)});
      triangles.push_back({at(j, i), at(j + 1, i + 1), at(j, i + 1)});
    }
  }
  return {std::make_shared<const TriangleMesh>(corners, triangles)};
}

} // namespace tactus::haptic::test
