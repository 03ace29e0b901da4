#include "core/reed/guidance_field.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::reed {
namespace {

constexpr double kSpacing = 1.0 / (GuidanceField::kNodes - 1);
constexpr double kFar = 1e6; // squared distance where there is no such node
constexpr int kReach = 4;    // of the blur, nodes: more than 3 standard deviations
static_assert(kReach >= 3 * GuidanceField::kBlur / kSpacing);

/// Squared distances along one row or column: least of f(q) + (p - q)^2 over all q (Felzenszwalb &
/// Huttenlocher 2012), by direct search, the lines being short.
void spread(std::vector<double>& squares, std::size_t start, std::size_t stride,
            std::vector<double>& line) noexcept {
  for (std::size_t p = 0; p < GuidanceField::kNodes; ++p) {
    double least = kFar;
    for (std::size_t q = 0; q < GuidanceField::kNodes; ++q) {
      const double way = (static_cast<double>(p) - static_cast<double>(q)) * kSpacing;
      least = std::min(least, squares[start + q * stride] + way * way);
    }
    line[p] = least;
  }
  for (std::size_t p = 0; p < GuidanceField::kNodes; ++p)
    squares[start + p * stride] = line[p];
}

} // namespace

void GuidanceField::prepare() {
  distance_.resize(kNodes, kNodes);
  plays_.assign(kNodes * kNodes, 0);
  outside_.assign(kNodes * kNodes, 0);
  inside_.assign(kNodes * kNodes, 0);
  line_.assign(kNodes, 0);
}

/// From every node to the nearest one that plays (inside) or does not.
void GuidanceField::measure(bool inside, std::vector<double>& distance) noexcept {
  for (std::size_t n = 0; n < plays_.size(); ++n)
    distance[n] = (plays_[n] != 0) == inside ? 0 : kFar;
  for (std::size_t k = 0; k < kNodes; ++k)
    spread(distance, k * kNodes, 1, line_);
  for (std::size_t i = 0; i < kNodes; ++i)
    spread(distance, i, kNodes, line_);
  for (double& d : distance)
    d = std::sqrt(d);
}

/// Along the lines of that stride. Beyond the plane's edge the values are mirrored through the edge
/// (2 f(0) - f(j)), which leaves a slope as it is.
void GuidanceField::blur(std::vector<double>& values, std::size_t stride) noexcept {
  const std::size_t other = stride == 1 ? kNodes : 1;
  constexpr int last = static_cast<int>(kNodes) - 1;
  for (std::size_t at = 0; at < kNodes; ++at) {
    const auto value = [&](int p) {
      return values[at * other + static_cast<std::size_t>(p) * stride];
    };
    const auto beyond = [&](int p) {
      return p < 0      ? 2 * value(0) - value(-p)
             : p > last ? 2 * value(last) - value(2 * last - p)
                        : value(p);
    };
    for (int p = 0; p <= last; ++p) {
      double sum = 0, weights = 0;
      for (int j = -kReach; j <= kReach; ++j) {
        const double x = j * kSpacing / kBlur;
        const double weight = std::exp(-0.5 * x * x);
        sum += weight * beyond(p + j);
        weights += weight;
      }
      line_[static_cast<std::size_t>(p)] = sum / weights;
    }
    for (std::size_t p = 0; p < kNodes; ++p)
      values[at * other + p * stride] = line_[p];
  }
}

void GuidanceField::build(const GradientField& quality, double threshold) noexcept {
  for (std::size_t k = 0; k < kNodes; ++k)
    for (std::size_t i = 0; i < kNodes; ++i)
      plays_[k * kNodes + i] =
          quality.value(distance_.y_of(i), distance_.z_of(k)) >= threshold ? 1 : 0;
  measure(true, outside_);
  measure(false, inside_);
  // The border lies half-way between nodes; without any the distance is the same everywhere.
  for (std::size_t n = 0; n < plays_.size(); ++n)
    outside_[n] = plays_[n] ? 0.5 * kSpacing - inside_[n] : outside_[n] - 0.5 * kSpacing;
  blur(outside_, 1);
  blur(outside_, kNodes);
  for (std::size_t k = 0; k < kNodes; ++k)
    for (std::size_t i = 0; i < kNodes; ++i)
      distance_.node(i, k) = outside_[k * kNodes + i];
  distance_.differentiate();
}

} // namespace tactus::reed
