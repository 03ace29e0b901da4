#include "core/stress/update_policy.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::stress {

void CostModel::learn(const Reanalysis::Result& result, double ratio) noexcept {
  if (result.method == Method::kPcg && result.iterations > 0)
    scale_ =
        std::clamp(result.iterations / (kBaseIterations + kIterationsPerRatio * ratio), 0.1, 100.0);
}

double CostModel::iterations(double ratio) const noexcept {
  return scale_ * (kBaseIterations + kIterationsPerRatio * ratio);
}

double CostModel::pcg_s(double ratio) const noexcept {
  return iterations(ratio) * (costs_.product_s + costs_.solve_s);
}

Method CostModel::cheapest(double ratio) const noexcept {
  return iterations(ratio) > kMaxIterations || pcg_s(ratio) > full_s() ? Method::kFull
                                                                       : Method::kPcg;
}

std::optional<Method> UpdatePolicy::due(double now_s, Resolve resolve, double trust_ratio,
                                        double factor_ratio) const noexcept {
  if (resolve == Resolve::kTaylor || !(trust_ratio > kMinRatio) ||
      (trust_ratio <= 1 && !at_rest(now_s)))
    return {};
  switch (resolve) {
  case Resolve::kPcg:
    return Method::kPcg;
  case Resolve::kFull:
    return Method::kFull;
  default:
    return costs.cheapest(factor_ratio);
  }
}

} // namespace tactus::stress
