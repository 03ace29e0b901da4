#include "core/contact/body_lanes.hpp"

namespace tactus::contact {

const BodyKernel& baseline_body_kernel() noexcept {
  static const BodyLanes<simd::Baseline> kernel;
  return kernel;
}

const BodyKernel& body_kernel() noexcept { return baseline_body_kernel(); }

} // namespace tactus::contact
