#pragma once

#include <algorithm>
#include <cstddef>
#include <vector>

namespace tactus::reed {

/// Squared distance of a node from those that are sought, where none is known.
inline constexpr double kFarSquared = 1e6;

/// Squared distances along one row or column of nodes `spacing` apart: least of
/// f(q) + (p - q)^2 spacing^2 over all q (Felzenszwalb & Huttenlocher 2012), by direct search, the
/// lines being short. `line` holds at least count numbers.
inline void spread_squares(std::vector<double>& squares, std::size_t start, std::size_t stride,
                           std::size_t count, double spacing, std::vector<double>& line) noexcept {
  for (std::size_t p = 0; p < count; ++p) {
    double least = kFarSquared;
    for (std::size_t q = 0; q < count; ++q) {
      const double way = (static_cast<double>(p) - static_cast<double>(q)) * spacing;
      least = std::min(least, squares[start + q * stride] + way * way);
    }
    line[p] = least;
  }
  for (std::size_t p = 0; p < count; ++p)
    squares[start + p * stride] = line[p];
}

/// Turns 0 at the nodes that are sought and kFarSquared elsewhere, row after row, into the squared
/// distance of every node from the nearest one sought. `line` holds the longer of a row and a
/// column.
inline void spread_squares(std::vector<double>& squares, std::size_t columns, std::size_t rows,
                           double column_spacing, double row_spacing,
                           std::vector<double>& line) noexcept {
  for (std::size_t k = 0; k < rows; ++k)
    spread_squares(squares, k * columns, 1, columns, column_spacing, line);
  for (std::size_t i = 0; i < columns; ++i)
    spread_squares(squares, i, columns, rows, row_spacing, line);
}

} // namespace tactus::reed
