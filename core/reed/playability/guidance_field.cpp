#include "core/reed/playability/guidance_field.hpp"

#include "core/dsp/elementary.hpp"
#include "core/reed/playability/distance_transform.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <vector>

namespace tactus::reed {
namespace {

constexpr double kSpacing = 1.0 / (GuidanceField::kNodes - 1);
constexpr int kBlurRadius = 4; // radius of the blur, nodes: more than 3 standard deviations
static_assert(kBlurRadius >= 3 * GuidanceField::kBlur / kSpacing);

using Nodes = std::vector<double>;
constexpr std::size_t kNodes = GuidanceField::kNodes;

/// Distance of every node to the nearest node that plays (inside = true) or does not play.
Nodes distances(const std::vector<char>& plays, bool inside) {
  Nodes distance(plays.size());
  for (std::size_t n = 0; n < plays.size(); ++n)
    distance[n] = (plays[n] != 0) == inside ? 0 : kUnreachedSquared;
  Nodes line(kNodes);
  distance_transform(distance, kNodes, kNodes, kSpacing, kSpacing, line);
  for (double& d : distance)
    d = std::sqrt(d);
  return distance;
}

/// Gaussian blur along the lines of this stride. Beyond the edge of the plane the values are
/// continued by point reflection, 2 f(0) - f(j), which preserves a slope.
void blur(Nodes& values, std::size_t stride) {
  const std::size_t line_stride = stride == 1 ? kNodes : 1;
  constexpr int last = static_cast<int>(kNodes) - 1;
  std::array<double, kBlurRadius + 1> weight;
  double weight_sum = 0;
  for (std::size_t j = 0; j < weight.size(); ++j) {
    const double x = static_cast<double>(j) * kSpacing / GuidanceField::kBlur;
    weight[j] = math::exp(-0.5 * x * x);
    weight_sum += j == 0 ? weight[j] : 2 * weight[j];
  }
  std::array<double, kNodes> line;
  for (std::size_t at = 0; at < kNodes; ++at) {
    const auto value = [&](int p) {
      return values[at * line_stride + static_cast<std::size_t>(p) * stride];
    };
    const auto extended_value = [&](int p) {
      return p < 0      ? 2 * value(0) - value(-p)
             : p > last ? 2 * value(last) - value(2 * last - p)
                        : value(p);
    };
    for (int p = 0; p <= last; ++p) {
      double sum = 0;
      for (int j = -kBlurRadius; j <= kBlurRadius; ++j)
        sum += weight[static_cast<std::size_t>(std::abs(j))] * extended_value(p + j);
      line[static_cast<std::size_t>(p)] = sum / weight_sum;
    }
    for (std::size_t p = 0; p < kNodes; ++p)
      values[at * line_stride + p * stride] = line[p];
  }
}

} // namespace

void GuidanceField::build(const GradientField& quality, double threshold) {
  distance_.resize(kNodes, kNodes);
  std::vector<char> plays(kNodes * kNodes);
  for (std::size_t k = 0; k < kNodes; ++k)
    for (std::size_t i = 0; i < kNodes; ++i)
      plays[k * kNodes + i] =
          quality.value(distance_.y_of(i), distance_.z_of(k)) >= threshold ? 1 : 0;
  Nodes distance = distances(plays, true);
  const Nodes inside = distances(plays, false);
  // The border lies half-way between nodes. Without a border the distance is constant.
  for (std::size_t n = 0; n < plays.size(); ++n)
    distance[n] = plays[n] != 0 ? 0.5 * kSpacing - inside[n] : distance[n] - 0.5 * kSpacing;
  blur(distance, 1);
  blur(distance, kNodes);
  for (std::size_t k = 0; k < kNodes; ++k)
    for (std::size_t i = 0; i < kNodes; ++i)
      distance_.node(i, k) = distance[k * kNodes + i];
  distance_.differentiate();
}

} // namespace tactus::reed
