#pragma once
#include "fem/error/balance.hpp"
#include "fem/mesh/mesh.hpp"
#include "fem/mesh/size_field.hpp"

#include <optional>

namespace tactus::fem {

/// Sizes with which every mode's error is at most `target`, with the fewest elements. Minimising
/// sum 1/f_i^3 under sum error_i f_i^order_i = target gives f_i^(order_i + 3) ~ 1 / (order_i
/// error_i). Cells are the mesh's elements. Sizes never grow, because they also resolve curved
/// faces. Over a distance d the size increases by d/2 at most.
[[nodiscard]] SizeField refined_sizes(const Mesh&, const ErrorCells&, double target);

/// The cells and layers of a swept CAD body (sweep.hpp).
struct SweptLayers {
  std::size_t columns = 0;    ///< cells of the base
  std::vector<double> levels; ///< shares of the height, 0 to 1
  [[nodiscard]] std::size_t intervals() const noexcept { return columns + levels.size() - 1; }
};
/// The columns and layers of a swept mesh; nullopt if some element is not a hex20 or wedge15 in a
/// column and a layer.
[[nodiscard]] std::optional<SweptLayers> swept_layers(const Mesh&);

/// As refined_sizes(), for a swept body: sizes in the base and levels that minimise (sum_c 1/f_c^2)
/// (sum_l 1/g_l). Cells are the columns, then the layers (interval_errors). Layers may grow by a
/// factor of 2.
[[nodiscard]] SizeField refined_swept_sizes(const Mesh&, const SweptLayers&, const ErrorCells&,
                                            double target);

} // namespace tactus::fem
