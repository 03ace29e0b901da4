#include "core/stress/feedback_lanes.hpp"

namespace tactus::stress {

// Defined in feedback_lanes_avx2.cpp, which is compiled for AVX2; null if the compiler cannot.
const FeedbackKernel* avx2_feedback_kernel() noexcept;

const FeedbackKernel& baseline_feedback_kernel() noexcept {
  static const FeedbackLanes<simd::Baseline> kernel;
  return kernel;
}

const FeedbackKernel& feedback_kernel() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  if (const FeedbackKernel* newer = avx2_feedback_kernel(); newer && __builtin_cpu_supports("avx2"))
    return *newer;
#endif
  return baseline_feedback_kernel();
}

} // namespace tactus::stress
