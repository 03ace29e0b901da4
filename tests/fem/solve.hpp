#pragma once
#include "fem/modes/body.hpp"
#include "fem/shapes/shapes.hpp"

#include <doctest/doctest.h>

namespace tactus::fem {

struct SolvedModes {
  Mesh mesh;
  Matrices matrices;
  Modes modes;
};

inline SolvedModes solve_modes(Mesh mesh, const Material& material, std::size_t count,
                               std::span<const Support> supports = {}) {
  set_solver_threads(1);
  check(mesh);
  const std::vector<Material> materials(mesh.regions.size(), material);
  Matrices matrices = assemble(mesh, materials, supports);
  ModeSettings settings;
  settings.count = count;
  Modes modes = find_modes(mesh, materials, matrices, settings);
  return {std::move(mesh), std::move(matrices), std::move(modes)};
}

/// Relative difference is below `tolerance`.
inline void check_close(double value, double reference, double tolerance) {
  CAPTURE(value);
  CAPTURE(reference);
  CHECK(std::abs(value / reference - 1) < tolerance);
}

/// Nodes on a plane.
inline std::vector<int> nodes_on(const Mesh& mesh, int axis, double level) {
  std::vector<int> nodes;
  for (std::size_t i = 0; i < mesh.nodes.size(); ++i)
    if (std::abs(mesh.nodes[i][axis] - level) < 1e-9)
      nodes.push_back(static_cast<int>(i));
  return nodes;
}

} // namespace tactus::fem
