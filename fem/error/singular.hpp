#pragma once
#include "fem/mesh/mesh.hpp"

#include <array>

namespace tactus::fem {

/// Which elements touch a line where the stress is unbounded: an edge of the body with an inner
/// angle above 200 degrees, or the border of a held patch. There the displacement goes as r^a with
/// a < 1, and the error of an element as h^(2a) instead of h^4 (Strang & Fix 1973, chapter 8). A
/// part of a face that is half held and half free counts as the border.
[[nodiscard]] std::vector<std::uint8_t>
singular_elements(const Mesh&, std::span<const std::uint8_t> constrained);

/// Along which reference axes of swept elements (Element::interval) the stress is unbounded: an
/// axis that runs along the singular line sees it smooth. [element][axis].
[[nodiscard]] std::vector<std::array<std::uint8_t, 3>>
singular_axes(const Mesh&, std::span<const std::uint8_t> constrained);

} // namespace tactus::fem
