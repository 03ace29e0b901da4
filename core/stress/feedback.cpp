#include "core/stress/feedback_lanes.hpp"

namespace tactus::stress {

const FeedbackKernel& baseline_feedback_kernel() noexcept {
  static const FeedbackLanes<simd::Baseline> kernel;
  return kernel;
}
const FeedbackKernel& feedback_kernel() noexcept { return baseline_feedback_kernel(); }

} // namespace tactus::stress
