// The kernels for AVX2. CMake compiles this file with AVX2 enabled; on other architectures the
// functions return null.
#include "core/contact/body_lanes.hpp"
#include "core/contact/dense_lanes.hpp"

namespace tactus::contact {

const BodyKernel* avx2_body_kernel() noexcept;
const DenseKernel* avx2_dense_kernel() noexcept;

const BodyKernel* avx2_body_kernel() noexcept {
#if defined(__AVX2__)
  static const BodyLanes<simd::Avx2> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

const DenseKernel* avx2_dense_kernel() noexcept {
#if defined(__AVX2__)
  static const DenseLanes<simd::Avx2> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::contact
