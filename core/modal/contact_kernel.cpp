#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

// Each in a source file of its own, compiled for its instructions; null where they are unknown.
template <class T> const ContactKernel<T>* avx2_contact_kernel() noexcept;
template <class T> const ContactKernel<T>* avx512_contact_kernel() noexcept;

template <class T> const ContactKernel<T>* contact_kernel(VectorSet set) noexcept {
  if (!bank_kernel(set))
    return nullptr;
  switch (set) {
  case VectorSet::kAvx512:
    return avx512_contact_kernel<T>();
  case VectorSet::kAvx2:
    return avx2_contact_kernel<T>();
  case VectorSet::kBaseline:
    break;
  }
  static const ContactLanes<simd::Baseline, T> kernel;
  return &kernel;
}

template const ContactKernel<float>* contact_kernel<float>(VectorSet) noexcept;
template const ContactKernel<double>* contact_kernel<double>(VectorSet) noexcept;

} // namespace tactus::modal
