#include "fem/mesh/size_field.hpp"

#include <algorithm>
#include <limits>
#include <queue>

namespace tactus::fem {

SizeField::SizeField(std::vector<Vector3> points, std::vector<double> size)
    : point_(std::move(points)), size_(std::move(size)), box_(bounding_box(point_)) {
  // About two points a cell.
  const Vector3 extent = box_.size();
  const double flat = 1e-3 * box_.largest();
  const double space = (extent.x + flat) * (extent.y + flat) * (extent.z + flat);
  edge_ = std::max(std::cbrt(2 * space / static_cast<double>(point_.size())), box_.largest() / 500);
  for (int k = 0; k < 3; ++k)
    cells_[static_cast<std::size_t>(k)] = 1 + static_cast<int>(extent[k] / edge_);
  const auto count = static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                     static_cast<std::size_t>(cells_[2]);
  first_.assign(count + 1, 0);
  for (const Vector3& p : point_)
    ++first_[cell(p, 0, 0, 0) + 1];
  for (std::size_t c = 0; c < count; ++c)
    first_[c + 1] += first_[c];
  inside_.resize(point_.size());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < point_.size(); ++i)
    inside_[next[cell(point_[i], 0, 0, 0)]++] = i;
}

std::size_t SizeField::cell(const Vector3& p, int dx, int dy, int dz) const noexcept {
  const std::array<int, 3> step{dx, dy, dz};
  std::size_t index = 0;
  for (int k = 0; k < 3; ++k) {
    const int count = cells_[static_cast<std::size_t>(k)];
    const int at = std::clamp(static_cast<int>((p[k] - box_.low[k]) / edge_), 0, count - 1) +
                   step[static_cast<std::size_t>(k)];
    if (at < 0 || at >= count)
      return first_.size();
    index = index * static_cast<std::size_t>(count) + static_cast<std::size_t>(at);
  }
  return index;
}

double SizeField::at(const Vector3& p) const noexcept {
  double nearest = std::numeric_limits<double>::infinity(), size = size_[0];
  const int widest = std::max({cells_[0], cells_[1], cells_[2]});
  for (int ring = 0; ring <= widest; ++ring) {
    for (int i = -ring; i <= ring; ++i)
      for (int j = -ring; j <= ring; ++j)
        for (int k = -ring; k <= ring; ++k) {
          if (std::max({std::abs(i), std::abs(j), std::abs(k)}) != ring)
            continue;
          const std::size_t c = cell(p, i, j, k);
          if (c + 1 >= first_.size())
            continue;
          for (std::size_t n = first_[c]; n < first_[c + 1]; ++n) {
            const double away = length(point_[inside_[n]] - p);
            if (away < nearest) {
              nearest = away;
              size = size_[inside_[n]];
            }
          }
        }
    if (nearest <= ring * edge_) // farther cells hold nothing nearer
      break;
  }
  return size;
}

double SizeField::smallest() const noexcept {
  return *std::min_element(size_.begin(), size_.end());
}
double SizeField::largest() const noexcept { return *std::max_element(size_.begin(), size_.end()); }

namespace {

constexpr double kSlope = .5; ///< of sizes over distance

double mean_edge(const Mesh& mesh, std::span<const int> corners) {
  double sum = 0;
  int pairs = 0;
  for (std::size_t a = 0; a < corners.size(); ++a)
    for (std::size_t b = 0; b < a; ++b, ++pairs)
      sum += length(mesh.nodes[static_cast<std::size_t>(corners[a])] -
                    mesh.nodes[static_cast<std::size_t>(corners[b])]);
  return sum / pairs;
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
  const std::vector<double> factor = balanced_factors(cells, target, {}, rule, 8);
  // At each corner the smallest size that an element around wants.
  std::vector<double> wanted_at(mesh.nodes.size(), std::numeric_limits<double>::infinity());
  double count = 0;
  for (std::size_t e = 0; e < mesh.elements.size(); ++e) {
    const Element& element = mesh.elements[e];
    const auto corners =
        mesh.nodes_of(element).first(static_cast<std::size_t>(corner_count(element.shape)));
    const double wanted = mean_edge(mesh, corners) * factor[e];
    for (const int n : corners)
      wanted_at[static_cast<std::size_t>(n)] =
          std::min(wanted_at[static_cast<std::size_t>(n)], wanted);
    count += std::pow(factor[e], -3);
  }
  std::vector<int> number(mesh.nodes.size(), -1);
  std::vector<Vector3> points;
  std::vector<double> size;
  for (std::size_t n = 0; n < mesh.nodes.size(); ++n)
    if (std::isfinite(wanted_at[n])) {
      number[n] = static_cast<int>(points.size());
      points.push_back(mesh.nodes[n]);
      size.push_back(wanted_at[n]);
    }
  // Sizes grow from the small ones along the edges of the mesh (Dijkstra).
  std::vector<std::vector<int>> neighbours(points.size());
  for (const Element& element : mesh.elements) {
    const auto corners =
        mesh.nodes_of(element).first(static_cast<std::size_t>(corner_count(element.shape)));
    for (const int a : corners)
      for (const int b : corners)
        if (a != b)
          neighbours[static_cast<std::size_t>(number[static_cast<std::size_t>(a)])].push_back(
              number[static_cast<std::size_t>(b)]);
  }
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
  SizeField field(std::move(points), std::move(size));
  field.elements = count;
  field.straight = has_straight_sides(mesh);
  return field;
}

} // namespace tactus::fem
