// Compiled for AVX-512 (core/CMakeLists.txt); does nothing on other processors.
#include "core/reed/playability/gradient_lanes.hpp"

namespace tactus::reed {

std::unique_ptr<ReedEnsemble> make_avx512_ensemble();

std::unique_ptr<ReedEnsemble> make_avx512_ensemble() {
#if defined(__AVX512VL__)
  using V = simd::Lanes<float, ReedEnsemble::kLanes, simd::Avx512>;
  return std::unique_ptr<ReedEnsemble>(new LaneEnsemble<V>);
#else
  return nullptr;
#endif
}

} // namespace tactus::reed
