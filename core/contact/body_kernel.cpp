#include "core/contact/body_lanes.hpp"
#include "core/contact/dense_lanes.hpp"

namespace tactus::contact {

// Defined in body_lanes_avx2.cpp, which is compiled for AVX2; null if the compiler cannot.
const BodyKernel* avx2_body_kernel() noexcept;
const DenseKernel* avx2_dense_kernel() noexcept;

namespace {

#if defined(__x86_64__) || defined(__i386__)
[[nodiscard]] bool has_avx2() noexcept { return __builtin_cpu_supports("avx2") != 0; }
#endif

} // namespace

const BodyKernel& baseline_body_kernel() noexcept {
  static const BodyLanes<simd::Baseline> kernel;
  return kernel;
}
const DenseKernel& baseline_dense_kernel() noexcept {
  static const DenseLanes<simd::Baseline> kernel;
  return kernel;
}

const BodyKernel& body_kernel() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  if (const BodyKernel* newer = avx2_body_kernel(); newer && has_avx2())
    return *newer;
#endif
  return baseline_body_kernel();
}
const DenseKernel& dense_kernel() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  if (const DenseKernel* newer = avx2_dense_kernel(); newer && has_avx2())
    return *newer;
#endif
  return baseline_dense_kernel();
}

} // namespace tactus::contact
