#include "core/contact/body_lanes.hpp"

namespace tactus::contact {

// In a source file of its own, compiled for its instructions; null where they are unknown.
const BodyKernel* avx2_body_kernel() noexcept;

const BodyKernel& baseline_body_kernel() noexcept {
  static const BodyLanes<simd::Baseline> kernel;
  return kernel;
}

const BodyKernel& body_kernel() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  if (const BodyKernel* newer = avx2_body_kernel(); newer && __builtin_cpu_supports("avx2"))
    return *newer;
#endif
  return baseline_body_kernel();
}

} // namespace tactus::contact
