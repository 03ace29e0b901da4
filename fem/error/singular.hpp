#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>
#include <numbers>

namespace tactus::fem {

/// A larger turn of the skin from one facet to the next is an edge and not a round wall, rad.
inline constexpr double kSharpTurn = 20 * std::numbers::pi / 180;

/// Marks the nodes on a line of unbounded stress (see below). Concave edges count if they turn by
/// `turn` or more.
[[nodiscard]] std::vector<std::uint8_t>
singular_nodes(const Mesh&, std::span<const std::uint8_t> constrained, double turn);

/// Marks the elements that touch a line of unbounded stress: an edge of the body with an inner
/// angle above 200 degrees, or the border of a support. There the displacement varies as r^a with a
/// < 1, and the error of an element as h^(2a) instead of h^4 (Strang & Fix 1973, chapter 8). A face
/// that is partly supported and partly free counts as the border, unless its nodes are constrained
/// only along the face: such a support is a plane of symmetry, where the stress is bounded.
[[nodiscard]] std::vector<std::uint8_t>
singular_elements(const Mesh&, std::span<const std::uint8_t> constrained);

/// Marks the reference axes of swept elements (Element::interval) along which the stress is
/// unbounded. Along an axis parallel to the singular line, the stress is smooth. [element][axis].
[[nodiscard]] std::vector<std::array<std::uint8_t, 3>>
singular_axes(const Mesh&, std::span<const std::uint8_t> constrained);

} // namespace tactus::fem
