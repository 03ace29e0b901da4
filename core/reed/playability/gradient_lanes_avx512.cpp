// Compiled for AVX-512 (core/CMakeLists.txt).
#include "core/reed/playability/gradient_lanes.hpp"

namespace tactus::reed {

std::unique_ptr<ReedEnsemble> make_reed_ensemble(simd::Avx512) {
  using V = simd::Lanes<float, ReedEnsemble::kLanes, simd::Avx512>;
  return std::unique_ptr<ReedEnsemble>(new LaneEnsemble<V>);
}

} // namespace tactus::reed
