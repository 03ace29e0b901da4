#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>
#include <numbers>

namespace tactus::fem {

/// Beyond it the turn of the skin from one facet to the next is an edge, not a round wall, rad.
inline constexpr double kSharpTurn = 20 * std::numbers::pi / 180;

/// Which nodes lie on a line where the stress is unbounded (below); concave edges count from `turn`
/// on.
[[nodiscard]] std::vector<std::uint8_t>
singular_nodes(const Mesh&, std::span<const std::uint8_t> constrained, double turn);

/// Which elements touch a line of unbounded stress: an edge of the body with an inner angle above
/// 200 degrees, or the border of a support. There the displacement varies as r^a with a < 1, and
/// the error of an element as h^(2a) instead of h^4 (Strang & Fix 1973, chapter 8). A face that is
/// partly supported and partly free counts as the border, unless its nodes are constrained only
/// along the face: such a support is a plane of symmetry, where the stress is bounded.
[[nodiscard]] std::vector<std::uint8_t>
singular_elements(const Mesh&, std::span<const std::uint8_t> constrained);

/// Along which reference axes of swept elements (Element::interval) the stress is unbounded: an
/// axis that runs along the singular line sees it smooth. [element][axis].
[[nodiscard]] std::vector<std::array<std::uint8_t, 3>>
singular_axes(const Mesh&, std::span<const std::uint8_t> constrained);

} // namespace tactus::fem
