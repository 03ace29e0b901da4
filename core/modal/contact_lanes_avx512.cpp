// Compiled for AVX-512 (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

const ContactKernel* avx512_contact_kernel() noexcept;

const ContactKernel* avx512_contact_kernel() noexcept {
#if defined(__AVX512F__)
  static const ContactLanes<simd::Avx512> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::modal
