// Compiled for AVX2 and FMA (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

ContactKernels avx2_contact_kernels() noexcept;

ContactKernels avx2_contact_kernels() noexcept {
#if defined(__AVX2__) && defined(__FMA__)
  static const ContactLanes<simd::Avx2, float> single_precision;
  static const ContactLanes<simd::Avx2, double> double_precision;
  return {&single_precision, &double_precision};
#else
  return {};
#endif
}

} // namespace tactus::modal
