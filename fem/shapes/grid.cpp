#include "fem/shapes/section.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {
namespace {

constexpr double kGradation = 3;

/// Minimising prod_d N_d^p_d, N_d = sum_i 1/f_i, under sum_i error_i f_i^order_i = target gives
/// f_i^(order_i + 1) = p_d / (pressure order_i error_i N_d).
std::vector<double> factors(const SweepGrid& grid, std::span<const double> error,
                            std::span<const double> order, double pressure) {
  std::vector<double> factor(error.size(), 1e3);
  for (std::size_t d = 0; d < 3; ++d) {
    const std::size_t first = grid.first_interval(d), end = first + grid.interval_count(d);
    // A uniform direction counts as one interval, which stands for all.
    const double each = grid.uniform[d] > 0 ? static_cast<double>(grid.line[d].size() - 1) : 1;
    double number = each * static_cast<double>(end - first);
    for (int round = 0; round < 8; ++round) {
      double sum = 0;
      for (std::size_t i = first; i < end; ++i) {
        if (error[i] > 0)
          factor[i] = std::pow(pressure * order[i] * error[i] * number / (each * grid.power[d]),
                               -1 / (order[i] + 1));
        sum += each / std::min(factor[i], 1e3);
      }
      number = std::sqrt(number * sum);
    }
  }
  return factor;
}

/// Limits the ratio of neighbouring intervals' sizes to `kGradation`.
void smooth(std::span<const double> line, std::span<double> factor) {
  const auto size = [&](std::size_t i) { return line[i + 1] - line[i]; };
  const std::size_t n = factor.size();
  for (std::size_t i = 1; i < n; ++i)
    factor[i] = std::min(factor[i], kGradation * size(i - 1) * factor[i - 1] / size(i));
  for (std::size_t i = n - 1; i-- > 0;)
    factor[i] = std::min(factor[i], kGradation * size(i + 1) * factor[i + 1] / size(i));
}

/// Splits singular intervals geometrically, with a factor of 3 per step, from the ends where the
/// singular line may be. Such an end is shared by a singular neighbour or is the body's own end.
/// Equal parts would waste elements.
void grade_singular(std::vector<double>& line, std::vector<double>& factor,
                    std::span<const double> order) {
  std::vector<double> lines{line[0]}, factors;
  const auto singular = [&](std::size_t i) {
    return order[i] < .5 * (kSmoothOrder + kSingularOrder);
  };
  for (std::size_t i = 0; i < factor.size(); ++i) {
    if (!singular(i) || factor[i] > .5) {
      lines.push_back(line[i + 1]);
      factors.push_back(factor[i]);
      continue;
    }
    const Ends ends{i == 0 || singular(i - 1), i + 1 == factor.size() || singular(i + 1)};
    const double size = line[i + 1] - line[i];
    const bool inside = !ends.low && !ends.high;
    const auto parts = divide(
        {line[i], line[i + 1], size, 1, inside ? Ends{true, true} : ends, factor[i] * size, 3});
    for (std::size_t p = 1; p < parts.size(); ++p) {
      lines.push_back(parts[p]);
      factors.push_back(1);
    }
  }
  line = std::move(lines);
  factor = std::move(factors);
}

/// Makes new lines with the density 1 / (factor size) of the old intervals, and includes the kept
/// lines.
std::vector<double> divided(const std::vector<double>& line, std::span<const double> kept,
                            std::span<const double> factor) {
  const double near = 1e-9 * (line.back() - line.front());
  std::vector<double> out{line.front()};
  for (std::size_t k = 0, i = 0; k + 1 < kept.size(); ++k) {
    std::vector<double> position{line[i]}, measure{0}; // number of elements up to each old line
    for (; i + 1 < line.size() && line[i + 1] <= kept[k + 1] + near; ++i) {
      position.push_back(line[i + 1]);
      measure.push_back(measure.back() + 1 / factor[i]);
    }
    const int count = std::max(1, static_cast<int>(std::ceil(measure.back() - .1)));
    for (int c = 1, at = 0; c < count; ++c) {
      const double target_measure = measure.back() * c / count;
      while (measure[static_cast<std::size_t>(at) + 1] < target_measure)
        ++at;
      const auto j = static_cast<std::size_t>(at);
      out.push_back(position[j] + (position[j + 1] - position[j]) * (target_measure - measure[j]) /
                                      (measure[j + 1] - measure[j]));
    }
    out.push_back(position.back());
  }
  return out;
}

} // namespace

std::vector<double> redistribute(std::vector<double> line, std::span<const double> kept,
                                 std::vector<double> factor, std::span<const double> order) {
  grade_singular(line, factor, order);
  smooth(line, factor);
  return divided(line, kept, factor);
}

SweepGrid refined(const SweepGrid& grid, const ErrorCells& cells, double target, double coarsest) {
  std::vector<double> factor = balanced_factors(
      cells, target, {.finest = 1. / 16, .coarsest = coarsest},
      [&](std::span<const double> error, double pressure) {
        return factors(grid, error, cells.order, pressure);
      },
      60);
  SweepGrid finer = grid;
  for (std::size_t d = 0; d < 3; ++d) {
    const std::span<double> own =
        std::span(factor).subspan(grid.first_interval(d), grid.interval_count(d));
    const std::vector<double>& line = grid.line[d];
    if (grid.uniform[d] > 0) {
      const int step = grid.uniform[d];
      const double intervals = static_cast<double>(line.size() - 1) / own[0];
      const int count = step * std::max(step > 1 ? 16 / step : 1,
                                        static_cast<int>(std::ceil(intervals / step - .1)));
      finer.line[d].clear();
      for (int i = 0; i <= count; ++i)
        finer.line[d].push_back(line.front() + (line.back() - line.front()) * i / count);
      continue;
    }
    finer.line[d] =
        redistribute(line, grid.kept[d], {own.begin(), own.end()},
                     std::span(cells.order).subspan(grid.first_interval(d), own.size()));
  }
  return finer;
}

} // namespace tactus::fem
