// Compiled for AVX2 and FMA (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

template <class T> const ContactKernel<T>* avx2_contact_kernel() noexcept;

template <class T> const ContactKernel<T>* avx2_contact_kernel() noexcept {
#if defined(__AVX2__) && defined(__FMA__)
  static const ContactLanes<simd::Avx2, T> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

template const ContactKernel<float>* avx2_contact_kernel<float>() noexcept;
template const ContactKernel<double>* avx2_contact_kernel<double>() noexcept;

} // namespace tactus::modal
