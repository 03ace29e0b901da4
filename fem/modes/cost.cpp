#include "fem/modes/cost.hpp"

#include "fem/modes/lanczos.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace tactus::fem {
namespace {

constexpr auto kBlock = static_cast<double>(kLanczosBlock);

/// Nested dissection of a block, which halves it across the longest side, down to one element.
/// `touching` is the number of the block's ends, along each direction, that lie on older
/// separators.
class Dissection {
public:
  explicit Dissection(double on_planes) : on_planes_(on_planes) {}
  FactorCost operator()(std::array<double, 3> cells) {
    for (double& c : cells)
      c = std::max(c, 1.0);
    return split(cells, {0, 0, 0}, 0);
  }

private:
  using Touching = std::array<int, 3>;

  /// Number of nodes on a plane of a by b elements: that of hex20, times `on_planes`.
  [[nodiscard]] double plane(double a, double b) const {
    return on_planes_ * ((a + 1) * (b + 1) + a * (b + 1) + (a + 1) * b);
  }

  static FactorCost front(double columns, double rows_below) {
    const double s = 3 * columns, b = 3 * rows_below;
    return {.entries = s * s / 2 + s * b, .operations = s * s * s / 3 + s * s * b + s * b * b};
  }

  [[nodiscard]] double older_nodes(const std::array<double, 3>& c, const Touching& t) const {
    return t[0] * plane(c[1], c[2]) + t[1] * plane(c[0], c[2]) + t[2] * plane(c[0], c[1]);
  }

  FactorCost split(std::array<double, 3> cells, Touching touching, int level) {
    const auto [at, added] = known_.try_emplace({level, touching});
    if (!added)
      return at->second;
    const auto longest =
        static_cast<std::size_t>(std::max_element(cells.begin(), cells.end()) - cells.begin());
    const std::size_t p = (longest + 1) % 3, q = (longest + 2) % 3;
    FactorCost cost;
    if (cells[longest] <= 1.5) { // a leaf has only an element's interior nodes, almost none
      cost = front(2, older_nodes(cells, touching));
    } else {
      const double separator =
          plane(cells[p], cells[q]) *
          // excludes nodes on ends at older separators, which are already counted
          std::max(.2, 1 - .5 * (touching[p] / cells[p] + touching[q] / cells[q]));
      cost = front(separator, older_nodes(cells, touching));
      cells[longest] /= 2;
      const int ends = touching[longest];
      Touching low = touching, high = touching; // each half keeps at most one old end
      low[longest] = 1 + (ends > 0);
      high[longest] = 1 + (ends > 1);
      for (const Touching& half : {low, high}) {
        const FactorCost part = split(cells, half, level + 1);
        cost.entries += part.entries;
        cost.operations += part.operations;
      }
    }
    return known_[{level, touching}] = cost;
  }

  double on_planes_;
  std::map<std::pair<int, Touching>, FactorCost> known_;
};

} // namespace

FactorCost predict_factor(const MeshSize& size) {
  FactorCost cost = Dissection(size.nodes_on_planes)(size.cells);
  // Supernodes are stored as rectangles, which needs about a fifth more. The matrix itself adds 9
  // entries of 16 bytes per pair of nodes.
  cost.memory_bytes = 8 * 1.2 * cost.entries + 144 * size.node_pairs;
  return cost;
}

namespace {

constexpr double kMeshNode = 24, kMeshElement = 104, kMatrixPair = 88; // bytes

/// Adds the times of the factorisation and of all work, on one core; `factor` is the cost of
/// factorising the matrix.
void add_seconds(Cost& cost, const Workload& work, const FactorCost& factor) {
  const MeshSize& mesh = work.mesh;
  const double pairs = mesh.node_pairs;
  const double panels = work.acoustic_triangles, unknowns = panels / 2;
  // Measured on one core: the factorisation has half of the dense speed, a solve reads 1.5
  // Gentries/s, assembly takes 1 us per node pair, and a pair of panels takes 60 ns.
  const double solves = 2.5 * work.modes + 40;
  const double solutions = work.solutions > 0 ? work.solutions : work.modes;
  cost.factor_seconds = factor.operations / (.5 * work.flops_per_second);
  cost.seconds = 1e-6 * pairs + (1 + work.residual) * cost.factor_seconds +
                 2 * solves * factor.entries / 3e9 + 4e-9 * mesh.dofs() * solves * solves;
  if (panels > 0)
    cost.seconds += solutions * (6e-8 * panels * panels + 8. / 3 * unknowns * unknowns * unknowns /
                                                              (.5 * work.flops_per_second));
}

} // namespace

double bytes_of_results(const MeshSize& mesh, double modes) {
  return kMeshNode * mesh.nodes + kMeshElement * mesh.elements + kMatrixPair * mesh.node_pairs +
         8 * mesh.dofs() * std::min(modes, mesh.dofs());
}

Cost predict_cost(const Workload& work, const std::optional<FactorCost>& exact) {
  const MeshSize& mesh = work.mesh;
  const FactorCost factor = exact ? *exact : predict_factor(mesh);
  const double vector = 8 * mesh.dofs(), pairs = mesh.node_pairs;
  const double found = std::min(work.modes, mesh.dofs()) + 4;
  const double basis_columns = std::min(4 * found + 12 * kBlock, mesh.dofs()) + kBlock;
  const double lanes = 2 * kBlock * vector; // columns side by side in a product with K or M

  constexpr double kProgram = 60e6; // memory of program and libraries without a body
  const double started = kProgram + work.retained_bytes;
  const double raw = started + kMeshNode * mesh.nodes + kMeshElement * mesh.elements;
  const double assembled = raw + kMatrixPair * pairs;
  const double shapes = std::min(work.modes, mesh.dofs()) * vector;
  // CHOLMOD permutes a copy of the matrix while it factorises.
  const double factorising = factor.memory_bytes + 144 * pairs;
  const double factored = factor.memory_bytes - 144 * pairs;

  Cost cost;
  const auto stage = [&](double bytes, const char* name) {
    if (bytes > cost.bytes) {
      cost.bytes = bytes;
      cost.stage = name;
    }
  };
  stage(started + 60 * mesh.nodes_made + 80 * mesh.nodes + 104 * mesh.elements, "meshing");
  if (work.factor_elsewhere) { // both triangles are exported at once
    stage(assembled + 300 * pairs, "exporting the matrices");
    stage(assembled + 4 * found * vector + lanes, "importing the modes");
  } else {
    stage(assembled + factorising, "the factorisation");
    const double projected =
        4 * 8 * basis_columns * basis_columns; // the small eigenproblem and its copies
    stage(assembled + factored + projected +
              std::max(basis_columns + found + 6 * kBlock, 4 * found) * vector + lanes,
          "the basis of the modes");
    if (work.estimated) {
      // Memory of the blocks and vectors of an element's enriching functions. hex20 has 19, of
      // which 7 are not shared with neighbours; tet10 has 10, of which about 3.5 are not shared.
      const double element = mesh.nodes_on_planes < 1 ? 10e3 : 30e3;
      stage(assembled + factored + shapes + (element + 12 * work.modes) * mesh.elements + 3 * lanes,
            "the error estimate");
    }
  }
  stage(assembled + 88 * pairs + 2 * shapes + lanes, "the table");
  if (work.residual)
    stage(assembled + shapes + factorising + 4 * kBlock * vector, "the residual compliance");
  const double panels = work.acoustic_triangles, unknowns = panels / 2;
  // About 200 neighbours of each panel are integrated in closed form and stored, 220 bytes each.
  const double air = panels > 0 ? 16 * unknowns * unknowns + 220 * 60 * panels : 0;
  // The skin is coarsened before the air's equations are solved.
  stage(assembled + shapes + air + 700 * mesh.skin_triangles * (panels > 0),
        "the air around the body");

  add_seconds(cost, work, factor);
  return cost;
}

} // namespace tactus::fem
