#include "core/modal/bank/bank_lanes.hpp"

namespace tactus::modal {

// Each in a source file that is compiled for its instruction set; null where the compiler lacks it.
const BankKernel* avx2_bank_kernel() noexcept;
const BankKernel* avx512_bank_kernel() noexcept;

namespace {

bool runs(VectorSet set) noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  switch (set) {
  case VectorSet::kAvx512:
    return __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
           __builtin_cpu_supports("avx512vl");
  case VectorSet::kAvx2:
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  case VectorSet::kBaseline:
    break;
  }
  return true;
#else
  return set == VectorSet::kBaseline;
#endif
}

} // namespace

const BankKernel* bank_kernel(VectorSet set) noexcept {
  if (!runs(set))
    return nullptr;
  switch (set) {
  case VectorSet::kAvx512:
    return avx512_bank_kernel();
  case VectorSet::kAvx2:
    return avx2_bank_kernel();
  case VectorSet::kBaseline:
    break;
  }
  static const BankLanes<simd::Baseline> kernel;
  return &kernel;
}

VectorSet best_vector_set() noexcept {
  for (const VectorSet set : {VectorSet::kAvx512, VectorSet::kAvx2})
    if (bank_kernel(set))
      return set;
  return VectorSet::kBaseline;
}

} // namespace tactus::modal
