#pragma once
#include "fem/design/reanalysis.hpp"
#include "fem/io/stress_table.hpp"
#include "programs/body/budget.hpp"
#include "programs/part_stress/options.hpp"

namespace tactus::fem {

/// Makes and checks the requested mesh. Refuses a mesh beyond the memory limit, separate parts and
/// bad elements.
[[nodiscard]] Mesh mesh_of(const PartOptions&, ProgressLine&);

/// Puts supports and loads on the mesh. Refuses a region that contains nothing and names the
/// option.
[[nodiscard]] StaticModel model_of(const PartOptions&, const Mesh&);

/// The parameters of the requested moves. Refuses a control point that may not move.
[[nodiscard]] std::vector<double> parameters_of(std::span<const Move>, const DesignSpace&);

} // namespace tactus::fem
