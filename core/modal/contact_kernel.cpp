#include "core/modal/contact_lanes.hpp"

namespace tactus::modal {

// Each in a source file of its own, compiled for its instructions; null where they are unknown.
const ContactKernel* avx2_contact_kernel() noexcept;
const ContactKernel* avx512_contact_kernel() noexcept;

const ContactKernel* contact_kernel(VectorSet set) noexcept {
  if (!bank_kernel(set))
    return nullptr;
  switch (set) {
  case VectorSet::kAvx512:
    return avx512_contact_kernel();
  case VectorSet::kAvx2:
    return avx2_contact_kernel();
  case VectorSet::kBaseline:
    break;
  }
  static const ContactLanes<simd::Baseline> kernel;
  return &kernel;
}

const ContactKernel& contact_kernel() noexcept {
  static const ContactKernel& widest = *contact_kernel(best_vector_set());
  return widest;
}

} // namespace tactus::modal
