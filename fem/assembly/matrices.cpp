#include "fem/assembly/matrices.hpp"

#include "fem/vector_clones.hpp"

#include <algorithm>
#include <cstdlib>

namespace tactus::fem {

NodeGraph::NodeGraph(const Mesh& mesh) : start(mesh.nodes.size() + 1, 0) {
  // Finds the elements around each node, then each node's neighbours with a higher number.
  const std::size_t count = mesh.nodes.size();
  std::vector<std::size_t> first(count + 1, 0);
  for (const int n : mesh.connectivity)
    ++first[static_cast<std::size_t>(n) + 1];
  for (std::size_t i = 0; i < count; ++i)
    first[i + 1] += first[i];
  std::vector<std::size_t> around(mesh.connectivity.size()), next(first.begin(), first.end() - 1);
  for (std::size_t e = 0; e < mesh.elements.size(); ++e)
    for (const int n : mesh.nodes_of(mesh.elements[e]))
      around[next[static_cast<std::size_t>(n)]++] = e;
  std::vector<std::size_t> visited(count, count);
  for (std::size_t column = 0; column < count; ++column) {
    const auto begin = static_cast<std::ptrdiff_t>(row.size());
    for (std::size_t k = first[column]; k < first[column + 1]; ++k)
      for (const int n : mesh.nodes_of(mesh.elements[around[k]])) {
        const auto i = static_cast<std::size_t>(n);
        if (i >= column && visited[i] != column) {
          visited[i] = column;
          row.push_back(n);
        }
      }
    std::sort(row.begin() + begin, row.end());
    start[column + 1] = static_cast<std::int64_t>(row.size());
  }
}

std::size_t NodeGraph::find(std::int64_t at_row, std::int64_t column) const noexcept {
  const auto begin = row.begin() + start[static_cast<std::size_t>(column)];
  const auto end = row.begin() + start[static_cast<std::size_t>(column) + 1];
  return static_cast<std::size_t>(std::lower_bound(begin, end, at_row) - row.begin());
}

namespace {

/// Number of vectors multiplied together, so that the matrix is read from memory once for all of
/// them.
constexpr std::size_t kPassColumns = 8;
template <std::size_t Width> using ColumnLanes = std::array<double, Width>;

template <std::size_t Width>
void add(ColumnLanes<Width>& y, double a, const ColumnLanes<Width>& x) noexcept {
  for (std::size_t c = 0; c < Width; ++c)
    y[c] += a * x[c];
}

/// y = A x from the lower blocks of a symmetric matrix; block(k, x, y, transposed) adds block k of
/// A, or its transpose, times x[0..2] to y[0..2]. Rows and columns in `constrained` count as zero;
/// `constrained` may be empty.
template <std::size_t Width, class Block>
void multiply(const NodeGraph& graph, std::span<const std::uint8_t> constrained,
              std::span<const double> x, std::span<double> y, std::size_t columns,
              const Block& block) {
  const std::size_t n = 3 * graph.node_count();
  const auto skipped = [&](std::size_t i) { return !constrained.empty() && constrained[i]; };
  std::vector<ColumnLanes<Width>> in(n), out(n);
  for (std::size_t first = 0; first < columns; first += Width) {
    const std::size_t width = std::min(Width, columns - first);
    for (std::size_t i = 0; i < n; ++i) {
      out[i] = in[i] = {};
      for (std::size_t c = 0; c < width && !skipped(i); ++c)
        in[i][c] = x[(first + c) * n + i];
    }
    for (std::size_t column = 0; column < graph.node_count(); ++column)
      for (auto k = static_cast<std::size_t>(graph.start[column]);
           k < static_cast<std::size_t>(graph.start[column + 1]); ++k) {
        const auto r = static_cast<std::size_t>(graph.row[k]);
        block(k, &in[3 * column], &out[3 * r], false);
        if (r != column)
          block(k, &in[3 * r], &out[3 * column], true);
      }
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t c = 0; c < width; ++c)
        y[(first + c) * n + i] = skipped(i) ? 0 : out[i][c];
  }
}

/// A single vector would use only one of eight lanes, so it has a separate kernel.
template <class Block>
void multiply_any(const NodeGraph& graph, std::span<const std::uint8_t> constrained,
                  std::span<const double> x, std::span<double> y, std::size_t columns,
                  const Block& block) {
  if (columns == 1)
    multiply<1>(graph, constrained, x, y, columns, block);
  else
    multiply<kPassColumns>(graph, constrained, x, y, columns, block);
}

auto stiffness_block(std::span<const double> stiffness) {
  return [stiffness](std::size_t k, const auto* from, auto* to, bool transposed) {
    const double* s = &stiffness[9 * k];
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        add(to[i], transposed ? s[3 * j + i] : s[3 * i + j], from[j]);
  };
}

} // namespace

TACTUS_VECTOR_CLONES [[gnu::flatten]] void
Matrices::multiply_mass(std::span<const double> x, std::span<double> y, std::size_t columns) const {
  multiply_any(graph, constrained, x, y, columns,
               [this](std::size_t k, const auto* from, auto* to, bool) {
                 for (std::size_t i = 0; i < 3; ++i)
                   add(to[i], mass[k], from[i]);
               });
}

TACTUS_VECTOR_CLONES [[gnu::flatten]] void Matrices::multiply_stiffness(std::span<const double> x,
                                                                        std::span<double> y,
                                                                        std::size_t columns) const {
  multiply_any(graph, constrained, x, y, columns, stiffness_block(stiffness));
}

void Matrices::multiply_whole_stiffness(std::span<const double> x, std::span<double> y) const {
  multiply_any(graph, {}, x, y, 1, stiffness_block(stiffness));
}

PairPositions::PairPositions(const Mesh& mesh, const NodeGraph& graph) : start_{0} {
  if (graph.row.size() > 0x7FFFFFFE)
    throw TooLarge("the mesh has more than 2^31 pairs of nodes: use a coarser mesh");
  for (const Element& e : mesh.elements) {
    const auto nodes = mesh.nodes_of(e);
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b) {
        const bool transposed = nodes[a] < nodes[b];
        const auto k = static_cast<std::int32_t>(
            graph.find(std::max(nodes[a], nodes[b]), std::min(nodes[a], nodes[b])) + 1);
        position_.push_back(transposed ? -k : k);
      }
    start_.push_back(position_.size());
  }
}

void add_element_stiffness(const Mesh& mesh, std::size_t element, const ElasticLaw& law,
                           const PairPositions& positions, std::span<double> stiffness,
                           std::span<const std::uint8_t> only) {
  StiffnessBlocks blocks;
  const Element& e = mesh.elements[element];
  element_stiffness(mesh, e, law, blocks);
  const auto n = static_cast<std::size_t>(node_count(e.shape));
  const std::int32_t* position = positions.of(element).data();
  for (std::size_t a = 0; a < n; ++a)
    for (std::size_t b = 0; b <= a; ++b, ++position) {
      const bool transposed = *position < 0;
      const auto k = static_cast<std::size_t>(transposed ? -*position : *position) - 1;
      if (!only.empty() && !only[k])
        continue;
      const double* from = &blocks[9 * (a * n + b)];
      double* to = &stiffness[9 * k];
      for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
          to[3 * i + j] += transposed ? from[3 * j + i] : from[3 * i + j];
    }
}

std::vector<ElasticLaw> elastic_laws(const Mesh& mesh, std::span<const Material> materials) {
  if (materials.size() != mesh.regions.size())
    throw InputError("the mesh has " + std::to_string(mesh.regions.size()) + " regions and " +
                     std::to_string(materials.size()) + " materials, expected one for each");
  return {materials.begin(), materials.end()};
}

void assemble_stiffness(const Mesh& mesh, std::span<const Material> materials, int region,
                        Matrices& into) {
  const auto laws = elastic_laws(mesh, materials);
  const PairPositions positions(mesh, into.graph);
  into.stiffness.assign(9 * into.graph.row.size(), 0.0);
  for (std::size_t k = 0; k < mesh.elements.size(); ++k)
    if (const int own = mesh.elements[k].region; region < 0 || own == region)
      add_element_stiffness(mesh, k, laws[static_cast<std::size_t>(own)], positions,
                            into.stiffness);
}

Matrices assemble(const Mesh& mesh, std::span<const Material> materials,
                  std::span<const Support> supports, const Progress& progress) {
  const auto laws = elastic_laws(mesh, materials);
  Matrices matrices(mesh);
  const PairPositions positions(mesh, matrices.graph);
  matrices.stiffness.assign(9 * matrices.graph.row.size(), 0.0);
  matrices.mass.assign(matrices.graph.row.size(), 0.0);
  MassEntries entries;
  for (std::size_t k = 0; k < mesh.elements.size(); ++k) {
    const Element& e = mesh.elements[k];
    const ElasticLaw& law = laws[static_cast<std::size_t>(e.region)];
    add_element_stiffness(mesh, k, law, positions, matrices.stiffness);
    element_mass(mesh, e, law.density, entries);
    const auto nodes = mesh.nodes_of(e);
    const std::int32_t* position = positions.of(k).data();
    for (std::size_t a = 0; a < nodes.size(); ++a)
      for (std::size_t b = 0; b <= a; ++b, ++position)
        matrices.mass[static_cast<std::size_t>(std::abs(*position)) - 1] +=
            entries[a * nodes.size() + b];
    if (progress && k % 1024 == 0)
      progress(static_cast<double>(k) / static_cast<double>(mesh.elements.size()));
  }
  for (const Support& support : supports) {
    if (support.nodes.empty())
      throw InputError("support " + support.name +
                       " selects no node: expected a region of the body");
    const double share = support.stiffness_n_per_m / static_cast<double>(support.nodes.size());
    for (const int node : support.nodes) {
      const std::size_t diagonal = matrices.graph.find(node, node);
      for (std::size_t i = 0; i < 3; ++i)
        if (support.directions[i]) {
          if (share > 0)
            matrices.stiffness[9 * diagonal + 4 * i] += share;
          else
            matrices.constrained[3 * static_cast<std::size_t>(node) + i] = 1;
        }
    }
  }
  if (progress)
    progress(1);
  return matrices;
}

} // namespace tactus::fem
