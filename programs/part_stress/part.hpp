#pragma once
#include "fem/design/reanalysis.hpp"
#include "fem/io/stress_table.hpp"
#include "programs/body/budget.hpp"
#include "programs/part_stress/options.hpp"

namespace tactus::fem {

/// The requested mesh, checked. Refuses a mesh beyond the memory limit, separate parts and bad
/// elements.
[[nodiscard]] Mesh mesh_of(const PartOptions&, ProgressLine&);

/// Supports and loads on the mesh. Refuses a region that contains nothing, naming the option.
[[nodiscard]] StaticModel model_of(const PartOptions&, const Mesh&);

/// The parameters of the ordered moves. Refuses a control point that may not move.
[[nodiscard]] std::vector<double> parameters_of(std::span<const Move>, const DesignSpace&);

} // namespace tactus::fem
