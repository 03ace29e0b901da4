#pragma once
#include "fem/element/matrices.hpp"
#include "fem/mesh/mesh.hpp"

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace tactus::fem {

/// The sparsity pattern of K and M: the pairs of nodes that share an element. Lower triangle,
/// compressed by columns, rows ascending, with the diagonal.
struct NodeGraph {
  std::vector<std::int64_t> start; ///< node count + 1
  std::vector<std::int64_t> row;

  explicit NodeGraph(const Mesh&);
  [[nodiscard]] std::size_t node_count() const noexcept { return start.size() - 1; }
  /// Position of (row, column), row >= column; both must share an element.
  [[nodiscard]] std::size_t find(std::int64_t at_row, std::int64_t column) const noexcept;
};

/// The index in the node graph of each pair of nodes of each element. They are computed once and
/// used by every assembly.
class PairPositions {
public:
  /// Refuses graphs of more than 2^31 pairs.
  PairPositions(const Mesh&, const NodeGraph&);
  /// The positions of an element's node pairs (a, b), b <= a, in that order. A position is the
  /// pair's index + 1, negative if the block is stored transposed.
  [[nodiscard]] std::span<const std::int32_t> of(std::size_t element) const noexcept {
    return std::span(position_).subspan(start_[element], start_[element + 1] - start_[element]);
  }
  [[nodiscard]] std::size_t bytes() const noexcept {
    return sizeof(std::int32_t) * position_.size() + sizeof(std::size_t) * start_.size();
  }

private:
  std::vector<std::size_t> start_;
  std::vector<std::int32_t> position_;
};

/// A support: nodes that are fixed or on springs in the chosen directions. The stiffness (N/m) is
/// that of the whole patch, divided equally among its nodes.
struct Support {
  std::string name;
  std::vector<int> nodes;
  std::array<bool, 3> directions{true, true, true};
  double stiffness_n_per_m = 0; ///< 0 for a rigid support
};

/// The symmetric matrices of K u = omega^2 M u, in SI. K is stored in 3 x 3 blocks over the node
/// graph, row by row in each block. M has one number for each pair of nodes, the same for x, y and
/// z. Constrained directions keep their rows and are marked in `constrained`, so that solvers skip
/// them.
struct Matrices {
  NodeGraph graph;
  std::vector<double> stiffness;         ///< 9 per pair
  std::vector<double> mass;              ///< 1 per pair
  std::vector<std::uint8_t> constrained; ///< 1 per degree of freedom

  explicit Matrices(const Mesh& mesh) : graph(mesh), constrained(mesh.dofs(), 0) {}
  [[nodiscard]] std::size_t dofs() const noexcept { return constrained.size(); }

  /// y = M x and y = K x for `columns` vectors, each contiguous and dofs() long. Rows and columns
  /// of constrained directions count as zero.
  void multiply_mass(std::span<const double> x, std::span<double> y, std::size_t columns) const;
  void multiply_stiffness(std::span<const double> x, std::span<double> y,
                          std::size_t columns) const;
  /// y = K x with all rows and columns, including those of constrained directions.
  void multiply_whole_stiffness(std::span<const double> x, std::span<double> y) const;
};

/// Called with the completed fraction of the work, 0 to 1.
using Progress = std::function<void(double)>;

/// Integrates and adds up the matrices of all elements and the springs of the supports. `materials`
/// has one entry per region; refuses another number.
[[nodiscard]] Matrices assemble(const Mesh&, std::span<const Material>, std::span<const Support>,
                                const Progress& = {});

/// An elastic law for each region. Refuses a number of materials that differs from the number of
/// regions.
[[nodiscard]] std::vector<ElasticLaw> elastic_laws(const Mesh&, std::span<const Material>);

/// Adds an element's stiffness to the blocks `stiffness` of the graph to which `positions` belongs.
/// If `only` is not empty, adds it only to the pairs that `only` marks.
void add_element_stiffness(const Mesh&, std::size_t element, const ElasticLaw&,
                           const PairPositions&, std::span<double> stiffness,
                           std::span<const std::uint8_t> only = {});

/// Assembles only the stiffness of the elements in one region (-1: all), onto an existing graph.
void assemble_stiffness(const Mesh&, std::span<const Material>, int region, Matrices& into);

} // namespace tactus::fem
