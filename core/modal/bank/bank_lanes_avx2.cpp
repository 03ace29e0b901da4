// Compiled for AVX2 and FMA (core/CMakeLists.txt).
#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

const BankKernel* bank_kernel(simd::Avx2) noexcept {
  static const BankLanes<simd::Avx2> kernel;
  return &kernel;
}

} // namespace tactus::modal
