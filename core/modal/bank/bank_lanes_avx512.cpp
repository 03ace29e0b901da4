// Compiled for AVX-512 (core/CMakeLists.txt); the functions return null on other processors.
#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

const BankKernel* avx512_bank_kernel() noexcept;

const BankKernel* avx512_bank_kernel() noexcept {
#if defined(__AVX512F__)
  static const BankLanes<simd::Avx512> kernel;
  return &kernel;
#else
  return nullptr;
#endif
}

} // namespace tactus::modal
