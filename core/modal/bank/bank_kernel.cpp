#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

const BankKernel* bank_kernel(simd::Baseline) noexcept {
  static const BankLanes<simd::Baseline> kernel;
  return &kernel;
}
const BankKernel* bank_kernel(VectorSet widest) noexcept {
  return simd::dispatch<simd::Avx512, simd::Avx2>(widest,
                                                  [](auto set) { return bank_kernel(set); });
}

} // namespace tactus::modal
