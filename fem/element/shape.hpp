#pragma once
#include "core/geometry/vec3.hpp"

#include <array>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace tactus::fem {

/// Finite elements by their number of nodes. Nodes are numbered as in VTK and Abaqus: corners
/// first, then the edges of the lower face, of the upper face, and between them.
///
///     tet10           3            wedge15  3-------5       hex20   7-------6
///                   / | \                   | \   / |              /|      /|
///                  0--|--2                  |   4   |             4-------5 |
///                   \ | /                   0---|---2             | 3-----|-2
///                     1                       \ | /               |/      |/
///                                               1                 0-------1
///
/// Linear elements are far too stiff for frequencies; they are accepted only from files. pyramid5
/// has its apex last.
enum class Shape : std::uint8_t { tet4, tet10, hex8, hex20, wedge15, wedge6, pyramid5 };

inline constexpr std::size_t kShapes = 7;
inline constexpr int kMaxNodes = 20;

/// Returns the values of `make` for all shapes, in the order of the enumeration.
template <class Make> auto for_shapes(Make&& make) {
  return [&]<std::size_t... i>(std::index_sequence<i...>) {
    return std::array{make(static_cast<Shape>(i))...};
  }
  (std::make_index_sequence<kShapes>{});
}

[[nodiscard]] int node_count(Shape) noexcept;
[[nodiscard]] int corner_count(Shape) noexcept;
[[nodiscard]] bool is_linear(Shape) noexcept;
[[nodiscard]] std::string_view name(Shape) noexcept;
/// VTK's number of the cell type.
[[nodiscard]] int vtk_type(Shape) noexcept;

/// Values N of all shape functions at one reference point, and their reference derivatives dN.
struct ShapeValues {
  std::array<double, kMaxNodes> value;
  std::array<Vec3, kMaxNodes> derivative;
};

/// Reference element: tetrahedron r,s,t >= 0, r+s+t <= 1; wedge r,s >= 0, r+s <= 1, |t| <= 1;
/// hexahedron |r|,|s|,|t| <= 1; pyramid |r|,|s| <= 1 - t, t >= 0.
void evaluate(Shape, const Vec3& at, ShapeValues& out) noexcept;

/// Reference coordinates of each node.
[[nodiscard]] std::span<const Vec3> reference_nodes(Shape) noexcept;

/// A face's nodes in the element's numbering: corners counter-clockwise seen from outside, then the
/// edge nodes between them. Unused entries are -1.
struct Face {
  int corners;
  std::array<int, 8> node;
};
[[nodiscard]] std::span<const Face> faces(Shape) noexcept;

} // namespace tactus::fem
