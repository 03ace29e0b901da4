#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/scene/shape.hpp"

#include <cmath>
#include <memory>
#include <numbers>
#include <vector>

/// Meshes for tests.
namespace tactus::haptic::test {

/// A square of that side in the plane z = 0, centred, cells x cells squares of two triangles; its
/// corners regular, or each moved at random by up to half that part of a cell.
inline MeshSurface flat_mesh(std::uint32_t cells, double side_m, double irregular = 0) {
  Random random(12);
  const auto moved = [&](std::uint32_t i) {
    return irregular > 0 ? i + irregular * (random.uniform() - 0.5) : i;
  };
  std::vector<Vec3> corners;
  std::vector<Triangle> triangles;
  for (std::uint32_t j = 0; j <= cells; ++j)
    for (std::uint32_t i = 0; i <= cells; ++i)
      corners.push_back({side_m * (moved(i) / cells - 0.5), side_m * (moved(j) / cells - 0.5), 0});
  for (std::uint32_t j = 0; j < cells; ++j)
    for (std::uint32_t i = 0; i < cells; ++i) {
      const std::uint32_t a = j * (cells + 1) + i, b = a + 1, c = a + cells + 1, d = c + 1;
      triangles.push_back({a, b, d});
      triangles.push_back({a, d, c});
    }
  return {std::make_shared<const TriangleMesh>(corners, triangles)};
}

/// The triangles of corners on a sphere by longitude and latitude, the poles first and last: 2
/// around (along - 1).
inline std::vector<Triangle> sphere_triangles(std::uint32_t around, std::uint32_t along) {
  const std::uint32_t last = 1 + around * (along - 1);
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
  return triangles;
}

/// Its corners regular, or each moved over the sphere at random by up to half that part of the
/// distance to its neighbours: triangles of all sizes and angles, ridges and grooves.
inline MeshSurface mesh_sphere(double radius_m, std::uint32_t around, std::uint32_t along,
                               double irregular = 0) {
  Random random(11);
  const auto moved = [&](std::uint32_t i) {
    return irregular > 0 ? i + irregular * (random.uniform() - 0.5) : i;
  };
  std::vector<Vec3> corners{{0, 0, radius_m}};
  for (std::uint32_t j = 1; j < along; ++j)
    for (std::uint32_t i = 0; i < around; ++i) {
      const double latitude = std::numbers::pi * moved(j) / along,
                   longitude = 2 * std::numbers::pi * moved(i) / around;
      corners.push_back({radius_m * std::sin(latitude) * std::cos(longitude),
                         radius_m * std::sin(latitude) * std::sin(longitude),
                         radius_m * std::cos(latitude)});
    }
  corners.push_back({0, 0, -radius_m});
  return {std::make_shared<const TriangleMesh>(corners, sphere_triangles(around, along))};
}

} // namespace tactus::haptic::test
