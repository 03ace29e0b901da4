#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Squared distance of a node from which no target node is known.
inline constexpr double kUnreachedSquared = 1e6;

/// One pass of the Euclidean distance transform, along one row or column of nodes `spacing` apart:
/// f(p) becomes the minimum over q of f(q) + (p - q)^2 spacing^2 (Felzenszwalb & Huttenlocher
/// 2012). By direct search, because the lines are short. scratch holds at least count numbers.
inline void distance_transform(std::vector<double>& squared_distances, std::size_t start,
                               std::size_t stride, std::size_t count, double spacing,
                               std::vector<double>& scratch) noexcept {
  for (std::size_t p = 0; p < count; ++p) {
    double minimum = kUnreachedSquared;
    for (std::size_t q = 0; q < count; ++q) {
      const double offset = (static_cast<double>(p) - static_cast<double>(q)) * spacing;
      minimum = std::min(minimum, squared_distances[start + q * stride] + offset * offset);
    }
    scratch[p] = minimum;
  }
  for (std::size_t p = 0; p < count; ++p)
    squared_distances[start + p * stride] = scratch[p];
}

/// Euclidean distance transform of a grid, stored row by row. Input: 0 at the target nodes and
/// kUnreachedSquared elsewhere. Output: the squared distance of every node from the nearest target.
/// scratch holds at least max(columns, rows) numbers.
inline void distance_transform(std::vector<double>& squared_distances, std::size_t columns,
                               std::size_t rows, double column_spacing, double row_spacing,
                               std::vector<double>& scratch) noexcept {
  for (std::size_t k = 0; k < rows; ++k)
    distance_transform(squared_distances, k * columns, 1, columns, column_spacing, scratch);
  for (std::size_t i = 0; i < columns; ++i)
    distance_transform(squared_distances, i, columns, rows, row_spacing, scratch);
}

} // namespace tactus::reed
