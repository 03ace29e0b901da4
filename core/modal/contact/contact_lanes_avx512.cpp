// Compiled for AVX-512 (core/CMakeLists.txt).
#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

ContactKernels contact_kernels(simd::Avx512) noexcept {
  static const ContactLanes<simd::Avx512, float> single_precision;
  static const ContactLanes<simd::Avx512, double> double_precision;
  return {&single_precision, &double_precision};
}

} // namespace tactus::modal
