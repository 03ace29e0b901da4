#include "core/dsp/vector_set.hpp"

#include <doctest/doctest.h>

using namespace tactus::simd;

TEST_CASE("the widest set that the processor runs is chosen, but none above the limit") {
  const auto chosen = [](VectorSet limit) {
    return dispatch<Avx512, Avx2>(limit, [](auto set) { return decltype(set)::kSet; });
  };
  CHECK(runs(VectorSet::kBaseline));
  CHECK((runs(VectorSet::kAvx2) || !runs(VectorSet::kAvx512)));
  for (const VectorSet limit : {VectorSet::kBaseline, VectorSet::kAvx2, VectorSet::kAvx512}) {
    VectorSet widest = VectorSet::kBaseline;
    for (const VectorSet set : {VectorSet::kAvx2, VectorSet::kAvx512})
      if (set <= limit && runs(set))
        widest = set;
    CHECK(chosen(limit) == widest);
  }
}
