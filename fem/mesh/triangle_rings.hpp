#pragma once
#include "fem/io/triangles.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace tactus::fem {

/// Quality of a triangle: 1 if it is equilateral, 0 if it is a line.
[[nodiscard]] inline double quality(const Vec3& p, const Vec3& q, const Vec3& r) {
  const double a = length(q - p), b = length(r - q), c = length(p - r);
  const double sides = a * a + b * b + c * c;
  return sides > 0 ? 2 * std::sqrt(3.0) * length(cross(q - p, r - p)) / sides : 0;
}

/// Returns the points that triangles use, in the order of their use, and renumbers the corners
/// accordingly.
[[nodiscard]] inline std::vector<Vec3> used_points(std::vector<std::array<int, 3>>& triangles,
                                                   const std::vector<Vec3>& points) {
  std::vector<int> name(points.size(), -1);
  std::vector<Vec3> used;
  for (auto& corners : triangles)
    for (int& v : corners) {
      int& known = name[at(v)];
      if (known < 0) {
        known = static_cast<int>(used.size());
        used.push_back(points[at(v)]);
      }
      v = known;
    }
  return used;
}

/// The triangles of a closed surface and, for each point, the triangles around it, while edges
/// collapse. Remeshing, simplifying and the acoustic skin use it.
class TriangleRings {
protected:
  using Corners = std::array<int, 3>;

  TriangleRings(std::vector<Corners> triangles, std::size_t points)
      : triangle_(std::move(triangles)), around_(points) {
    for (std::size_t t = 0; t < triangle_.size(); ++t)
      for (const int v : triangle_[t])
        around_[at(v)].push_back(static_cast<int>(t));
  }

  [[nodiscard]] bool alive(std::size_t t) const { return triangle_[t][0] >= 0; }
  [[nodiscard]] static bool has(const Corners& corners, int v) {
    return std::find(corners.begin(), corners.end(), v) != corners.end();
  }
  /// The points with which a point shares an edge, in the order of their numbers.
  [[nodiscard]] std::vector<int> neighbours(int v) const {
    std::vector<int> out;
    out.reserve(2 * around_[at(v)].size());
    for (const int t : around_[at(v)])
      for (const int w : triangle_[at(t)])
        if (w != v)
          out.push_back(w);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }
  /// Whether two points share an edge that can collapse. They must not have more than two common
  /// neighbours, or the surface would be pinched, and at most `max_neighbours` neighbours in total.
  [[nodiscard]] bool
  can_merge(int from, int onto,
            std::size_t max_neighbours = std::numeric_limits<std::size_t>::max()) const {
    const auto a = neighbours(from), b = neighbours(onto);
    std::vector<int> common;
    std::set_intersection(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(common));
    return std::binary_search(a.begin(), a.end(), onto) && common.size() == 2 &&
           a.size() + b.size() <= max_neighbours;
  }
  /// Moves all triangles of a point to another point, and removes the triangles that share the edge
  /// between both points. Returns the number of removed triangles.
  std::size_t merge(int from, int onto) {
    std::size_t gone = 0;
    for (const int t : around_[at(from)]) {
      Corners& corners = triangle_[at(t)];
      if (has(corners, onto)) {
        for (const int v : corners)
          if (v != from)
            std::erase(around_[at(v)], t);
        corners = {-1, -1, -1};
        ++gone;
      } else {
        std::replace(corners.begin(), corners.end(), from, onto);
        around_[at(onto)].push_back(t);
      }
    }
    around_[at(from)].clear();
    return gone;
  }

  std::vector<Corners> triangle_; ///< -1 if removed
  std::vector<std::vector<int>> around_;
};

} // namespace tactus::fem
