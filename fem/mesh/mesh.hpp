#pragma once
#include "fem/element/shape.hpp"
#include "fem/material/material.hpp"

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

namespace tactus::fem {

/// An error for the user in one sentence with the object, its value and the expected value. In the
/// comments of fem "refuses" means: throws an InputError.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};
/// A mesh or result that is too large for the memory or the disk. Callers do not retry with another
/// meshing method.
struct TooLarge : InputError {
  using InputError::InputError;
};

/// One element: its nodes are `connectivity[first .. first + node_count)`.
struct Element {
  Shape shape;
  int region;
  std::size_t first;
  /// For a swept shape the interval of its grid that each reference axis spans
  /// (fem/shapes/grid.hpp), else -1. A wedge's axes are the sides at node 0, the side opposite node
  /// 0, and the prism's height.
  std::array<int, 3> interval{-1, -1, -1};
};

/// A volume mesh in metres. Regions carry materials; node sets carry names for supports.
struct Mesh {
  std::vector<Vec3> nodes;
  std::vector<int> connectivity;
  std::vector<Element> elements;
  std::vector<std::string> regions{"body"};
  std::vector<std::optional<Material>> materials; ///< materials of the regions, from the file; may
                                                  ///< be empty
  std::map<std::string, std::vector<int>> node_sets;

  void add(Shape shape, std::span<const int> element_nodes, int region = 0);
  [[nodiscard]] std::span<const int> nodes_of(const Element& e) const noexcept {
    return std::span(connectivity).subspan(e.first, static_cast<std::size_t>(node_count(e.shape)));
  }
  [[nodiscard]] std::size_t dofs() const noexcept { return 3 * nodes.size(); }
  /// The elements' names as a text, such as "hex20 + wedge15", for messages and tables.
  [[nodiscard]] std::string element_names() const;
};

struct Box {
  Vec3 low, high;
  [[nodiscard]] Vec3 size() const noexcept { return high - low; }
  [[nodiscard]] double largest() const noexcept;
};
[[nodiscard]] Box bounding_box(std::span<const Vec3> points);

/// Volume in m^3, by the mass quadrature.
[[nodiscard]] double volume(const Mesh&);

/// Connected parts: the part's number for every node, and the number of parts.
struct Parts {
  std::vector<int> of_node;
  int count = 0;
};
[[nodiscard]] Parts connected_parts(const Mesh&);

/// Removes nodes that no element uses and keeps the order of the others. Node sets follow.
void drop_unused_nodes(Mesh&);

/// For each point, the index of the point with which it merges: the first kept point within
/// `tolerance_m`, or itself.
[[nodiscard]] std::vector<int> coincident_points(std::span<const Vec3>, double tolerance_m);

/// Merges nodes closer than `tolerance_m`. Returns the number of removed nodes.
std::size_t merge_nodes(Mesh&, double tolerance_m);

/// The smallest Jacobian determinant at an element's quadrature points, m^3.
[[nodiscard]] double min_jacobian(const Mesh&, const Element&);

/// Whether the sides of all tet10 are straight, with the mid-edge node in the middle.
[[nodiscard]] bool has_straight_sides(const Mesh&);

/// Flattens edges of tet10 that curve so much that an element is inverted. The curvature is reduced
/// to a half, a quarter, then zero, until each Jacobian is at least 0.05 of that with straight
/// edges. Returns the number of moved nodes; elements with straight edges are unchanged.
std::size_t straighten_inverted(Mesh&);

/// Refuses meshes that cannot be solved, and names the element or node. The faults are indices out
/// of range, coordinates that are not finite, repeated nodes, and a Jacobian that is not positive
/// at a quadrature point or corner.
void check(const Mesh&);

/// Refuses a file's points beyond 1000 km: no real body has them, and products of such lengths
/// would overflow.
void check_range(const std::string& path, std::span<const Vec3> points);

} // namespace tactus::fem
