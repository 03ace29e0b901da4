// Compiled for AVX2 (core/CMakeLists.txt).
#include "core/stress/feedback_lanes.hpp"

namespace tactus::stress {

const FeedbackKernel* feedback_kernel(simd::Avx2) noexcept {
  static const FeedbackLanes<simd::Avx2> kernel;
  return &kernel;
}

} // namespace tactus::stress
