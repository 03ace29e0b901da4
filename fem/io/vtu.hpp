#pragma once
#include "fem/mesh/mesh.hpp"

#include <span>
#include <string>
#include <vector>

namespace tactus::fem {

/// Numbers at every node or in every element: `components` numbers for each, one after the other.
struct VtuField {
  std::string name;
  std::size_t components = 1;
  std::span<const double> values;
};

/// Writes the mesh with fields at its nodes and in its elements as VTK's unstructured grid (XML,
/// ASCII) for ParaView; the elements' regions are also written. Coordinates have nine digits,
/// fields seven. Refuses a field whose size does not match the mesh, or which has a value that is
/// not finite.
void write_vtu(const std::string& path, const Mesh&, std::span<const VtuField> at_nodes,
               std::span<const VtuField> in_elements);

} // namespace tactus::fem
