// Compiled for AVX2 (core/CMakeLists.txt); does nothing on other processors.
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
