#pragma once
#include "fem/design/lattice.hpp"
#include "fem/design/sensitivity.hpp"

#include <string>
#include <vector>

namespace tactus::fem {

/// Metadata of a stress table, written as JSON.
struct StressMetadata {
  std::string body_name, created; ///< created is ISO 8601 or empty
  std::vector<std::string> supports, loads;
  double mass = 0, volume = 0;                     ///< kg, m^3
  double max_displacement = 0;                     ///< m
  double product_s = 0, solve_s = 0, factor_s = 0; ///< measured on the machine that wrote the table
  std::vector<std::string> command;                ///< command line of part_stress
};

/// A part's stress and its derivatives by the control points: the contents of a stress table file.
struct StressTable {
  const Mesh& mesh;
  std::span<const Material> materials;
  std::span<const double> von_mises, max_shear; ///< at the centroids, [element], Pa
  const StressSensitivity& sensitivity;         ///< Pa/m
  std::span<const double> volumes;              ///< volumes of the elements, m^3
  std::vector<ParameterRange> parameters;
  const ControlWeights& control_weights; ///< weights of the mesh's nodes; the control points are
                                         ///< written
  std::array<int, 3> lattice{};          ///< control points along x, y, z
  double trust = 0;                      ///< m
  double skin_edge = 0;                  ///< edge length of the drawn skin, m; 0 for the mesh's
  StressMetadata metadata;
};

/// Writes NAME.stress.npz in SI units: meta (JSON), s0, shear0 [N], S, S_shear [P,N], weights [N],
/// parameters [P,4], control_points [C,3], trust, surface_nodes [V,3], surface_triangles [T,3],
/// surface_node_element [V], surface_weights [V,C] and, for solving again, mesh (bytes).
/// docs/formats/stress_table.md lists the arrays. A surface node takes the colour of its largest
/// element.
void write_stress_table(const std::string& path, const StressTable&);

/// For each vertex of the skin, the element whose stress is drawn there: the largest of the
/// elements that share the node.
[[nodiscard]] std::vector<std::int32_t> element_of_vertices(const Mesh&, const Surface&,
                                                            std::span<const double> volumes);

} // namespace tactus::fem
