// Compiled for AVX2 and FMA (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

const ContactKernel* avx2_contact_kernel() noexcept;

const ContactKernel* avx2_contact_kernel() noexcept {
#if defined(__AVX2__) && defined(__FMA__)
  static const ContactLanes<simd::Avx2> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::modal
