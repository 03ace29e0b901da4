// Compiled for AVX2 (core/CMakeLists.txt); does nothing on other processors.
#include "core/reed/playability/gradient_lanes.hpp"

namespace tactus::reed {

std::unique_ptr<ReedEnsemble> make_avx2_ensemble();

std::unique_ptr<ReedEnsemble> make_avx2_ensemble() {
#if defined(__AVX2__)
  using V = simd::Lanes<float, ReedEnsemble::kLanes, simd::Avx2>;
  return std::unique_ptr<ReedEnsemble>(new LaneEnsemble<V>);
#else
  return nullptr;
#endif
}

} // namespace tactus::reed
