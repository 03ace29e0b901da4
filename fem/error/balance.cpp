#include "fem/error/balance.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::fem {

std::vector<double> balanced_factors(const ErrorCells& cells, double target,
                                     const FactorLimits& limits, const FactorRule& rule,
                                     int rounds) {
  const std::size_t modes = cells.share.size(), count = cells.order.size();
  std::vector<double> weight(modes, 1.0 / static_cast<double>(modes)), factor, error(count),
      left(count), predicted(modes);
  double low = -60, high = 60; // bounds of ln pressure, narrowed in each round
  for (int round = 0; round < rounds; ++round) {
    std::fill(error.begin(), error.end(), 0.0);
    for (std::size_t k = 0; k < modes; ++k)
      for (std::size_t i = 0; i < count; ++i)
        error[i] += weight[k] * std::max(cells.share[k][i], 0.0);
    const auto largest_error = [&](double pressure) {
      factor = rule(error, std::exp(pressure));
      for (std::size_t i = 0; i < count; ++i) {
        factor[i] = std::clamp(factor[i], limits.finest, limits.coarsest);
        left[i] = std::pow(factor[i], cells.order[i]);
      }
      for (std::size_t k = 0; k < modes; ++k) {
        predicted[k] = 0;
        for (std::size_t i = 0; i < count; ++i)
          predicted[k] += std::max(cells.share[k][i], 0.0) * left[i];
      }
      return *std::max_element(predicted.begin(), predicted.end());
    };
    for (int step = 0; step < 40 && high - low > .01; ++step)
      (largest_error(.5 * (low + high)) > target ? low : high) = .5 * (low + high);
    const double largest = largest_error(high);
    if (!(largest > 0) || round + 1 == rounds)
      break;
    double sum = 0;
    for (std::size_t k = 0; k < modes; ++k)
      sum += weight[k] *= std::sqrt(predicted[k] / largest) + 1e-3;
    for (double& w : weight)
      w /= sum;
    low = high - 1;
    high += 1;
  }
  return factor;
}

} // namespace tactus::fem
