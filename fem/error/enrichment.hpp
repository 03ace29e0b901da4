#pragma once
#include "fem/mesh/mesh.hpp"

namespace tactus::fem {

/// Hierarchical shape functions that raise an element's space to the next polynomial degree.
/// Together with the nodal functions they are a basis of that space, continuous across elements of
/// any shape that share an edge or a face.
///
///   edge a-b    x (1 - x^2), x = l_b - l_a from the node of the lower number to that of the higher
///               (linear elements: 1 - x^2)
///   triangle    27 l_a l_b l_c                quadrilateral   (1 - x^2) (1 - y^2)
///   hexahedron  (1 - x^2) (1 - y^2) (1 - z^2)
///
/// blended linearly to zero at the opposite edges and faces (Szabo & Babuska 1991, chapter 6). With
/// them tet10 holds all cubics; hex20 and wedge15 too on parallelepipeds.
enum class EntityKind : std::uint8_t { edge, face, interior };

struct EnrichingFunction {
  EntityKind kind;
  std::array<int, 4> corner;   ///< corners of the edge or face; -1 if unused
  std::array<double, 3> share; ///< share of its variation along each reference axis
};

inline constexpr int kMaxEnriching = 19;

/// The enriching functions of a shape, in a fixed order. Reference axes as in `Element::interval`.
[[nodiscard]] std::span<const EnrichingFunction> enriching_functions(Shape) noexcept;

/// Values and reference derivatives at a point, edges oriented as listed. Further entries stay
/// unchanged.
void evaluate_enrichment(Shape, const Vec3& at, ShapeValues& out) noexcept;

/// The enriching functions of a mesh, numbered: the numbers of an element's functions begin at
/// `number[first[e]]`. `sign` is -1 if the element's orientation of an odd edge function is
/// opposite.
struct Enrichment {
  std::vector<std::size_t> first; ///< element count + 1
  std::vector<int> number;
  std::vector<std::int8_t> sign;
  std::size_t count = 0;
  std::vector<std::uint8_t> constrained; ///< 3 per function: all nodes of its edge or face are
                                         ///< constrained

  Enrichment(const Mesh&, std::span<const std::uint8_t> constrained_nodes);
};

} // namespace tactus::fem
