#include "core/stress/feedback_lanes.hpp"

namespace tactus::stress {

const FeedbackKernel* feedback_kernel(simd::Baseline) noexcept {
  static const FeedbackLanes<simd::Baseline> kernel;
  return &kernel;
}
const FeedbackKernel* feedback_kernel(simd::VectorSet widest) noexcept {
  return simd::dispatch<simd::Avx2>(widest, [](auto set) { return feedback_kernel(set); });
}

} // namespace tactus::stress
