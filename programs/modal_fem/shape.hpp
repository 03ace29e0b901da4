#pragma once
#include "fem/io/modal_table.hpp"
#include "programs/body/design_space.hpp"

namespace tactus::fem {

/// Number of modes found beyond the requested ones, so that no group of equal frequency is cut off.
inline constexpr std::size_t kModesBeyond = 4;

/// Derivatives of the first `count` squared frequencies with respect to the control points. If the
/// body extends through a face of the box, the points on that face are fixed, so that the body
/// stays in one piece. Points that move nothing are fixed too. Bounds are reduced where a
/// coordinate alone would invert an element.
[[nodiscard]] ShapeDerivatives shape_derivatives(const DesignOptions&, const Mesh&,
                                                 std::span<const Material>, const Modes&,
                                                 std::size_t count, ProgressLine&);

/// As above, for a moved mesh in the design space of the original mesh, whose bounds apply.
/// `displacement` is that of the parameters, m.
[[nodiscard]] ShapeDerivatives shape_derivatives(const DesignSpace&, const Mesh& moved,
                                                 std::span<const Material>, const Modes&,
                                                 std::size_t count,
                                                 std::vector<double> displacement);

} // namespace tactus::fem
