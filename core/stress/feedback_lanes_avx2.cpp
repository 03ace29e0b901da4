// The kernel for AVX2. CMake compiles this file with AVX2 enabled; on other architectures the
// function returns null.
#include "core/stress/feedback_lanes.hpp"

namespace tactus::stress {

const FeedbackKernel* avx2_feedback_kernel() noexcept;

const FeedbackKernel* avx2_feedback_kernel() noexcept {
#if defined(__AVX2__)
  static const FeedbackLanes<simd::Avx2> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::stress
