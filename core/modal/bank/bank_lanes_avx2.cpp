// Compiled for AVX2 and FMA (core/CMakeLists.txt); the functions return null on other processors.
#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

const BankKernel* avx2_bank_kernel() noexcept;

const BankKernel* avx2_bank_kernel() noexcept {
#if defined(__AVX2__) && defined(__FMA__)
  static const BankLanes<simd::Avx2> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::modal
