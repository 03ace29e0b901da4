#pragma once
#include "fem/mesh/surface.hpp"
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

/// A mode's displacement of the skin's vertices.
inline std::vector<Vec3> skin_motion(const SolvedModes& a, std::size_t mode) {
  std::vector<Vec3> motion;
  for (const int node : surface_of(a.mesh).node) {
    const double* u = &a.modes.shapes[mode * a.mesh.dofs() + 3 * static_cast<std::size_t>(node)];
    motion.push_back({u[0], u[1], u[2]});
  }
  return motion;
}

/// Relative difference is below `tolerance`.
inline void check_close(double value, double reference, double tolerance) {
  CAPTURE(value);
  CAPTURE(reference);
  CHECK(std::abs(value / reference - 1) < tolerance);
}

/// The work is refused in one sentence that has these words.
template <class Work> void check_refused(Work&& work, const std::string& words) {
  std::string said = "nothing was refused";
  try {
    (void)work();
  } catch (const InputError& refused) {
    said = refused.what();
  }
  CAPTURE(said);
  CHECK((said == "nothing was refused") == (words == "nothing was refused"));
  CHECK(said.find(words) != std::string::npos);
  CHECK(said.find('\n') == std::string::npos);
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
