// Compiled for AVX-512 (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

ContactKernels avx512_contact_kernels() noexcept;

ContactKernels avx512_contact_kernels() noexcept {
#if defined(__AVX512F__)
  static const ContactLanes<simd::Avx512, float> single_precision;
  static const ContactLanes<simd::Avx512, double> double_precision;
  return {&single_precision, &double_precision};
#else
  return {};
#endif
}

} // namespace tactus::modal
