#pragma once
#include "fem/io/modal_table.hpp"
#include "programs/body/design_space.hpp"

namespace tactus::fem {

/// Modes found beyond those that are asked for, so that no group of equal frequency is cut off.
inline constexpr std::size_t kModesBeyond = 4;

/// Derivatives of the first `count` squared frequencies with respect to the control points. Points
/// on a face of the box through which the body extends are fixed, so that it stays in one piece,
/// and so are those that move nothing. Bounds are reduced where a coordinate alone would invert an
/// element.
[[nodiscard]] ShapeDerivatives shape_derivatives(const DesignOptions&, const Mesh&,
                                                 std::span<const Material>, const Modes&,
                                                 std::size_t count, ProgressLine&);

/// The same of a moved mesh, in the design space of the mesh as it was: bounds stay those of the
/// first shape. `displacement`: of the parameters, m.
[[nodiscard]] ShapeDerivatives shape_derivatives(const DesignSpace&, const Mesh& moved,
                                                 std::span<const Material>, const Modes&,
                                                 std::size_t count,
                                                 std::vector<double> displacement);

} // namespace tactus::fem
