#pragma once
#include "fem/error/balance.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::fem {

/// The lines that cut a swept shape into elements, in its three directions: x, y, z of a box; along
/// the section (r, or the meridian), across it (z, or the wall), and around the axis of a body of
/// revolution. Coordinates are the shape's own.
struct SweepGrid {
  std::array<std::vector<double>, 3> line; ///< ascending
  std::array<std::vector<double>, 3> kept; ///< lines that no refinement may move: ends, corners
  /// If above 0, intervals are equal, their number is a multiple of this, and they count as a
  /// single interval. 0 allows any lines.
  std::array<int, 3> uniform{};
  /// The number of elements is proportional to the product of each direction's number of intervals
  /// to this power.
  std::array<double, 3> power{1, 1, 1};

  /// Intervals are numbered consecutively, first those of the first direction, then of the second,
  /// then of the third.
  [[nodiscard]] std::size_t interval_count(std::size_t direction) const noexcept {
    return uniform[direction] > 0 ? 1 : line[direction].size() - 1;
  }
  [[nodiscard]] std::size_t first_interval(std::size_t direction) const noexcept {
    std::size_t first = 0;
    for (std::size_t d = 0; d < direction; ++d)
      first += interval_count(d);
    return first;
  }
};

/// A direction's lines with the intervals' sizes multiplied by `factor`: singular intervals (by
/// `order`) are split geometrically towards the singular line, neighbours differ by at most a
/// factor of three, and `kept` lines stay.
[[nodiscard]] std::vector<double> redistribute(std::vector<double> line,
                                               std::span<const double> kept,
                                               std::vector<double> factor,
                                               std::span<const double> order);

/// Lines of a grid with which every mode's error is at most `target`, with the fewest elements.
/// Cells are the grid's intervals. Sizes change by factors from 1/16 to `coarsest`, and sizes of
/// neighbours differ by at most a factor of 3.
[[nodiscard]] SweepGrid refined(const SweepGrid&, const ErrorCells&, double target,
                                double coarsest = 2);

} // namespace tactus::fem
