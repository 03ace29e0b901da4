#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// A hex20 box between the coordinate lines; intervals are numbered x, y, z.
[[nodiscard]] Mesh block(std::span<const double> xs, std::span<const double> ys,
                         std::span<const double> zs);

} // namespace tactus::fem
