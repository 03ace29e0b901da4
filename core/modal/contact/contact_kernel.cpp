#include "core/modal/contact/contact_lanes.hpp"

namespace tactus::modal {

// Each in a source file that is compiled for its instruction set; null where the compiler lacks it.
ContactKernels avx2_contact_kernels() noexcept;
ContactKernels avx512_contact_kernels() noexcept;

namespace {

ContactKernels contact_kernels(VectorSet set) noexcept {
  if (!bank_kernel(set))
    return {};
  switch (set) {
  case VectorSet::kAvx512:
    return avx512_contact_kernels();
  case VectorSet::kAvx2:
    return avx2_contact_kernels();
  case VectorSet::kBaseline:
    break;
  }
  static const ContactLanes<simd::Baseline, float> single_precision;
  static const ContactLanes<simd::Baseline, double> double_precision;
  return {&single_precision, &double_precision};
}

} // namespace

template <> const ContactKernel<float>* contact_kernel<float>(VectorSet set) noexcept {
  return contact_kernels(set).single_precision;
}
template <> const ContactKernel<double>* contact_kernel<double>(VectorSet set) noexcept {
  return contact_kernels(set).double_precision;
}

} // namespace tactus::modal
