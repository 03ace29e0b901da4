// Compiled for AVX2 and FMA (core/CMakeLists.txt).
#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

ContactKernels contact_kernels(simd::Avx2) noexcept {
  static const ContactLanes<simd::Avx2, float> single_precision;
  static const ContactLanes<simd::Avx2, double> double_precision;
  return {&single_precision, &double_precision};
}

} // namespace tactus::modal
