#include "fem/error/refined_sizes.hpp"

#include "fem/shapes/grid.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>

namespace tactus::fem {
namespace {

constexpr double kSlope = .5; ///< slope of sizes over distance

double mean_edge(const Mesh& mesh, std::span<const int> corners) {
  double sum = 0;
  int pairs = 0;
  for (std::size_t a = 0; a < corners.size(); ++a)
    for (std::size_t b = 0; b < a; ++b, ++pairs)
      sum += length(mesh.nodes[static_cast<std::size_t>(corners[a])] -
                    mesh.nodes[static_cast<std::size_t>(corners[b])]);
  return sum / pairs;
}

/// The mean side of a triangle or quadrilateral.
double mean_side(const Mesh& mesh, std::span<const int> corners) {
  double sum = 0;
  for (std::size_t c = 0; c < corners.size(); ++c)
    sum += length(mesh.nodes[static_cast<std::size_t>(corners[(c + 1) % corners.size()])] -
                  mesh.nodes[static_cast<std::size_t>(corners[c])]);
  return sum / static_cast<double>(corners.size());
}

/// The size field of a mesh's cells with the given target sizes: each corner gets the smallest
/// target of the cells around it. Along the cells' edges, sizes grow by at most kSlope from smaller
/// ones (Dijkstra).
SizeField field_of(const Mesh& mesh, const std::vector<std::span<const int>>& cells,
                   std::span<const double> target_sizes) {
  std::vector<double> target_at(mesh.nodes.size(), std::numeric_limits<double>::infinity());
  for (std::size_t c = 0; c < cells.size(); ++c)
    for (const int n : cells[c])
      target_at[static_cast<std::size_t>(n)] =
          std::min(target_at[static_cast<std::size_t>(n)], target_sizes[c]);
  std::vector<int> number(mesh.nodes.size(), -1);
  std::vector<Vec3> points;
  std::vector<double> size;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (std::isfinite(target_at[n])) {
      number[n] = static_cast<int>(points.size());
      points.push_back(mesh.nodes[n]);
      size.push_back(target_at[n]);
    }
  std::vector<std::vector<int>> neighbours(points.size());
  for (const auto& corners : cells)
    for (const int a : corners)
      for (const int b : corners)
        if (a != b)
          neighbours[static_cast<std::size_t>(number[static_cast<std::size_t>(a)])].push_back(
              number[static_cast<std::size_t>(b)]);
  std::priority_queue<std::pair<double, int>> next; // the smallest first
  for (std::size_t i = 0; i < size.size(); ++i)
    next.emplace(-size[i], static_cast<int>(i));
  while (!next.empty()) {
    const auto [negative, i] = next.top();
    next.pop();
    const auto from = static_cast<std::size_t>(i);
    if (-negative > size[from])
      continue;
    for (const int j : neighbours[from]) {
      const auto to = static_cast<std::size_t>(j);
      const double limit = size[from] + kSlope * length(points[to] - points[from]);
      if (limit < size[to]) {
        size[to] = limit;
        next.emplace(-limit, j);
      }
    }
  }
  return {std::move(points), std::move(size)};
}

} // namespace

SizeField refined_sizes(const Mesh& mesh, const ErrorCells& cells, double target) {
  const auto rule = [&](std::span<const double> error, double pressure) {
    std::vector<double> factor(error.size(), 1e3);
    for (std::size_t i = 0; i < error.size(); ++i)
      if (error[i] > 0)
        factor[i] = std::pow(pressure * cells.order[i] * error[i], -1 / (cells.order[i] + 3));
    return factor;
  };
  std::vector<double> factor = balanced_factors(cells, target, {}, rule, 8);
  std::vector<std::span<const int>> corners;
  double count = 0;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    corners.push_back(mesh.nodes_of(mesh.elements[e])
                          .first(static_cast<std::size_t>(corner_count(mesh.elements[e].shape))));
    count += std::pow(factor[e], -3);
    factor[e] *= mean_edge(mesh, corners.back());
  }
  SizeField field = field_of(mesh, corners, factor);
  field.elements = count;
  field.straight = has_straight_sides(mesh);
  return field;
}

std::optional<SweptLayers> swept_layers(const Mesh& mesh) {
  std::size_t columns = 0, end = 0;
  for (const Element& e : mesh.elements) {
    if ((e.shape != Shape::wedge15 && e.shape != Shape::hex20) || e.interval[0] < 0 ||
        e.interval[1] != e.interval[0] || e.interval[2] < 0)
      return {};
    columns = std::max(columns, static_cast<std::size_t>(e.interval[0]) + 1);
    end = std::max(end, static_cast<std::size_t>(e.interval[2]) + 1);
  }
  if (columns == 0 || end <= columns || (end - columns) * columns != mesh.elements.size())
    return {};
  std::vector<double> thickness(end - columns, 0.0);
  for (const Element& e : mesh.elements) {
    if (static_cast<std::size_t>(e.interval[2]) < columns)
      return {};
    const auto nodes = mesh.nodes_of(e);
    const auto above = static_cast<std::size_t>(corner_count(e.shape) / 2);
    thickness[static_cast<std::size_t>(e.interval[2]) - columns] =
        length(mesh.nodes[static_cast<std::size_t>(nodes[above])] -
               mesh.nodes[static_cast<std::size_t>(nodes[0])]);
  }
  SweptLayers layers{columns, {0}};
  for (const double t : thickness)
    layers.levels.push_back(layers.levels.back() + t);
  for (double& level : layers.levels)
    level /= layers.levels.back();
  layers.levels.back() = 1;
  return layers;
}

SizeField refined_swept_sizes(const Mesh& mesh, const SweptLayers& swept, const ErrorCells& cells,
                              double target) {
  const std::size_t columns = swept.columns, all = swept.intervals();
  // f_c^(order + 2) = 2 N / (pressure order error), with N the new number of layers, and g_l^(order
  // + 1) = C / (pressure order error), with C the number of columns. N and C depend on each other.
  const auto rule = [&](std::span<const double> error, double pressure) {
    std::vector<double> factor(error.size(), 1e3);
    double base = static_cast<double>(columns), layers = static_cast<double>(all - columns);
    for (int round = 0; round < 8; ++round) {
      double new_base = 0, new_layers = 0;
      for (std::size_t i = 0; i < all; ++i) {
        const double p = pressure * cells.order[i] * error[i];
        if (error[i] > 0)
          factor[i] = i < columns ? std::min(1., std::pow(2 * layers / p, 1 / (cells.order[i] + 2)))
                                  : std::pow(base / p, 1 / (cells.order[i] + 1));
        const double part = 1 / std::min(factor[i], 1e3);
        (i < columns ? new_base : new_layers) += i < columns ? part * part : part;
      }
      base = std::sqrt(base * new_base);
      layers = std::sqrt(layers * new_layers);
    }
    return factor;
  };
  std::vector<double> factor =
      balanced_factors(cells, target, {.finest = 1. / 16, .coarsest = 2}, rule, 20);
  std::vector<std::span<const int>> cells_of_base(columns);
  double count = 0;
  for (const Element& e : mesh.elements)
    if (static_cast<std::size_t>(e.interval[2]) == columns) // the lowest layer
      cells_of_base[static_cast<std::size_t>(e.interval[0])] =
          mesh.nodes_of(e).first(static_cast<std::size_t>(corner_count(e.shape) / 2));
  for (std::size_t c = 0; c < columns; ++c) {
    factor[c] = std::min(factor[c], 1.0); // a cell without error keeps its size
    count += std::pow(factor[c], -2);
    factor[c] *= mean_side(mesh, cells_of_base[c]);
  }
  SizeField field = field_of(mesh, cells_of_base, std::span(factor).first(columns));
  field.levels = redistribute(swept.levels, std::array{0., 1.},
                              {factor.begin() + static_cast<std::ptrdiff_t>(columns), factor.end()},
                              std::span(cells.order).subspan(columns));
  field.elements = count * static_cast<double>(field.levels.size() - 1);
  return field;
}

} // namespace tactus::fem
