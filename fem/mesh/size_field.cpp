#include "fem/mesh/size_field.hpp"

#include <algorithm>
#include <limits>
#include <queue>

namespace tactus::fem {

SizeField::SizeField(std::vector<Vec3> points, std::vector<double> size)
    : point_(std::move(points)), size_(std::move(size)), box_(bounding_box(point_)) {
  // Chooses cells with about two points each.
  const Vec3 extent = box_.size();
  const double flat = 1e-3 * box_.largest();
  const double space = (extent.x + flat) * (extent.y + flat) * (extent.z + flat);
  edge_ = std::max(std::cbrt(2 * space / static_cast<double>(point_.size())), box_.largest() / 500);
  for (int k = 0; k < 3; ++k)
    cells_[static_cast<std::size_t>(k)] = 1 + static_cast<int>(extent[k] / edge_);
  const auto count = static_cast<std::size_t>(cells_[0]) * static_cast<std::size_t>(cells_[1]) *
                     static_cast<std::size_t>(cells_[2]);
  first_.assign(count + 1, 0);
  for (const Vec3& p : point_)
    ++first_[cell(p, 0, 0, 0) + 1];
  for (std::size_t c = 0; c < count; ++c)
    first_[c + 1] += first_[c];
  inside_.resize(point_.size());
  std::vector<std::size_t> next(first_.begin(), first_.end() - 1);
  for (std::size_t i = 0; i < point_.size(); ++i)
    inside_[next[cell(point_[i], 0, 0, 0)]++] = i;
}

std::size_t SizeField::cell(const Vec3& p, int dx, int dy, int dz) const noexcept {
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

double SizeField::at(const Vec3& p) const noexcept {
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
            const double distance = length(point_[inside_[n]] - p);
            if (distance < nearest) {
              nearest = distance;
              size = size_[inside_[n]];
            }
          }
        }
    if (nearest <= ring * edge_) // farther cells contain no nearer point
      break;
  }
  return size;
}

double SizeField::smallest() const noexcept {
  return *std::min_element(size_.begin(), size_.end());
}
double SizeField::largest() const noexcept { return *std::max_element(size_.begin(), size_.end()); }

} // namespace tactus::fem
