// Compiled for AVX-512 (core/CMakeLists.txt); does nothing on other processors.
#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

template <class T> const ContactKernel<T>* avx512_contact_kernel() noexcept;

template <class T> const ContactKernel<T>* avx512_contact_kernel() noexcept {
#if defined(__AVX512F__)
  static const ContactLanes<simd::Avx512, T> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

template const ContactKernel<float>* avx512_contact_kernel<float>() noexcept;
template const ContactKernel<double>* avx512_contact_kernel<double>() noexcept;

} // namespace tactus::modal
