#include "core/contact/body_lanes.hpp"
#include "core/contact/dense_lanes.hpp"

namespace tactus::contact {

const BodyKernel* body_kernel(simd::Baseline) noexcept {
  static const BodyLanes<simd::Baseline> kernel;
  return &kernel;
}
const DenseKernel* dense_kernel(simd::Baseline) noexcept {
  static const DenseLanes<simd::Baseline> kernel;
  return &kernel;
}

const BodyKernel* body_kernel(simd::VectorSet widest) noexcept {
  return simd::dispatch<simd::Avx2>(widest, [](auto set) { return body_kernel(set); });
}
const DenseKernel* dense_kernel(simd::VectorSet widest) noexcept {
  return simd::dispatch<simd::Avx2>(widest, [](auto set) { return dense_kernel(set); });
}

} // namespace tactus::contact
