// Compiled for AVX-512 (core/CMakeLists.txt).
#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

const BankKernel* bank_kernel(simd::Avx512) noexcept {
  static const BankLanes<simd::Avx512> kernel;
  return &kernel;
}

} // namespace tactus::modal
