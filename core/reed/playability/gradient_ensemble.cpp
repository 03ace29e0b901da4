#include "core/reed/playability/gradient_lanes.hpp"

namespace tactus::reed {

std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::Baseline) {
  return std::make_unique<LaneEnsemble<simd::Lanes<float, ReedEnsemble::kLanes>>>();
}
std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::VectorSet widest) {
  return simd::dispatch<simd::Avx512, simd::Avx2>(widest,
                                                  [](auto set) { return make_reed_ensemble(set); });
}

} // namespace tactus::reed
