// Compiled for AVX2 (core/CMakeLists.txt).
#include "core/contact/body_lanes.hpp"
#include "core/contact/dense_lanes.hpp"

namespace tactus::contact {

const BodyKernel* body_kernel(simd::Avx2) noexcept {
  static const BodyLanes<simd::Avx2> kernel;
  return &kernel;
}
const DenseKernel* dense_kernel(simd::Avx2) noexcept {
  static const DenseLanes<simd::Avx2> kernel;
  return &kernel;
}

} // namespace tactus::contact
