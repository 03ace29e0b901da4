#pragma once
#include "fem/design/reanalysis.hpp"
#include "static_bodies.hpp"

namespace tactus::fem {

/// The lattice of the specification around the cantilever: 5 x 3 x 3 control points, Bernstein.
inline Lattice cantilever_lattice() { return {{{0, 0, 0}, {.2, .02, .02}}, {5, 3, 3}, {4, 2, 2}}; }

/// Its row of top control points at mid-length, moved together along z; metres.
inline std::vector<DesignVelocity> top_row(const Mesh& mesh) {
  const Lattice lattice = cantilever_lattice();
  const std::vector<ShapeParameter> row{
      {"top row",
       {lattice.control(2, 0, 2), lattice.control(2, 1, 2), lattice.control(2, 2, 2)},
       {0, 0, 1}}};
  return design_velocities(embed(mesh, lattice), row);
}

/// The mesh with its nodes moved by one parameter.
inline Mesh moved_mesh(const Mesh& mesh, const DesignVelocity& velocity, double by) {
  Mesh moved = mesh;
  moved.nodes = moved_nodes(mesh.nodes, std::span(&velocity, 1), std::vector{by});
  return moved;
}

/// ||a - b|| / ||b||.
inline double relative_difference(std::span<const double> a, std::span<const double> b) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

/// von Mises stress of every element of the model, solved.
inline std::vector<double> solved_von_mises(const Mesh& mesh, const StaticModel& model) {
  return equivalent_stress(
      element_stress(mesh, model.materials, solve_static(mesh, model).solution.displacement),
      StressMeasure::von_mises);
}

/// (above - below) / (2 h), each.
inline std::vector<double> central_difference(std::vector<double> above,
                                              std::span<const double> below, double h) {
  for (std::size_t i = 0; i < above.size(); ++i)
    above[i] = (above[i] - below[i]) / (2 * h);
  return above;
}

} // namespace tactus::fem
