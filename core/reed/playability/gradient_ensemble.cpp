#include "core/reed/playability/gradient_lanes.hpp"

namespace tactus::reed {

// Each in a source file of its own, compiled for its instructions; null where they are unknown.
std::unique_ptr<ReedEnsemble> make_avx2_ensemble();
std::unique_ptr<ReedEnsemble> make_avx512_ensemble();

namespace {

bool runs(Instructions instructions) noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_cpu_init();
  switch (instructions) {
  case Instructions::kAvx512:
    return __builtin_cpu_supports("fma") && __builtin_cpu_supports("avx512f") &&
           __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl");
  case Instructions::kAvx2:
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
  case Instructions::kBaseline:
    break;
  }
  return true;
#else
  return instructions == Instructions::kBaseline;
#endif
}

} // namespace

std::unique_ptr<ReedEnsemble> make_reed_ensemble(Instructions instructions) {
  if (!runs(instructions))
    return nullptr;
  switch (instructions) {
  case Instructions::kAvx512:
    return make_avx512_ensemble();
  case Instructions::kAvx2:
    return make_avx2_ensemble();
  case Instructions::kBaseline:
    break;
  }
  return std::make_unique<LaneEnsemble<simd::Lanes<float, ReedEnsemble::kLanes, simd::Baseline>>>();
}

Instructions best_instructions() noexcept {
  for (const Instructions instructions : {Instructions::kAvx512, Instructions::kAvx2})
    if (runs(instructions))
      return instructions;
  return Instructions::kBaseline;
}

} // namespace tactus::reed
