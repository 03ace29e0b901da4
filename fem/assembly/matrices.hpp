#pragma once
#include "fem/material/material.hpp"
#include "fem/mesh/mesh.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tactus::fem {

/// Which nodes share an element: lower triangle by columns, rows ascending, the diagonal included.
struct NodeGraph {
  std::vector<std::int64_t> start; ///< node count + 1
  std::vector<std::int64_t> row;

  explicit NodeGraph(const Mesh&);
  [[nodiscard]] std::size_t node_count() const noexcept { return start.size() - 1; }
  /// Position of (row, column), row >= column; both must share an element.
  [[nodiscard]] std::size_t find(std::int64_t at_row, std::int64_t column) const noexcept;
};

/// A support. Nodes held in the chosen directions: rigidly, or by springs whose stiffness (N/m, the
/// sum over the patch) is shared equally among the nodes.
struct Support {
  std::string name;
  std::vector<int> nodes;
  std::array<bool, 3> directions{true, true, true};
  double stiffness_n_per_m = 0; ///< 0: rigid
};

/// The symmetric matrices of K u = omega^2 M u, in SI. K in 3 x 3 blocks over the node graph, row
/// by row in each block; M has one number a pair of nodes. Held directions keep their rows and are
/// marked in `held`: solvers skip them.
struct Matrices {
  NodeGraph graph;
  std::vector<double> stiffness;  ///< 9 a pair
  std::vector<double> mass;       ///< 1 a pair
  std::vector<std::uint8_t> held; ///< 1 a degree of freedom

  explicit Matrices(const Mesh& mesh) : graph(mesh), held(mesh.dofs(), 0) {}
  [[nodiscard]] std::size_t dofs() const noexcept { return held.size(); }

  /// y = M x and y = K x for `columns` vectors, each contiguous and dofs() long. Rows and columns
  /// of held directions count as zero.
  void multiply_mass(std::span<const double> x, std::span<double> y, std::size_t columns) const;
  void multiply_stiffness(std::span<const double> x, std::span<double> y,
                          std::size_t columns) const;
};

/// A share of the work that is done, 0 to 1.
using Progress = std::function<void(double)>;

/// One material a region. Refuses when the numbers differ.
[[nodiscard]] Matrices assemble(const Mesh&, std::span<const Material>, std::span<const Support>,
                                const Progress& = {});

/// The stiffness alone, of elements in one region (-1: all), onto an existing graph.
void assemble_stiffness(const Mesh&, std::span<const Material>, int region, Matrices& into);

} // namespace tactus::fem
