#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

ContactKernels contact_kernels(simd::Baseline) noexcept {
  static const ContactLanes<simd::Baseline, float> single_precision;
  static const ContactLanes<simd::Baseline, double> double_precision;
  return {&single_precision, &double_precision};
}
ContactKernels contact_kernels(VectorSet widest) noexcept {
  return simd::dispatch<simd::Avx512, simd::Avx2>(widest,
                                                  [](auto set) { return contact_kernels(set); });
}

} // namespace tactus::modal
