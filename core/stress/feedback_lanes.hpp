#pragma once

#include "core/dsp/vector.hpp"
#include "core/stress/feedback.hpp"

/// FeedbackKernel, written once for any instruction set. The set is a template parameter, so the
/// linker cannot use code for a newer processor in place of code for an older one. Sums run over
/// eight lanes, then across the lanes in a fixed order, without fused operations. So every set
/// gives the same bits.
namespace tactus::stress {

template <class Set>
class FeedbackLanes final : public FeedbackKernel, simd::Vectors<Set, double, 8> {
  using L = simd::Vectors<Set, double, 8>;
  using V = typename L::V;
  using L::across, L::all, L::kRegisters, L::kWidth, L::load, L::store;
  static constexpr std::size_t kLanes = 8;
  static constexpr std::size_t kTile = 1024; ///< elements; three arrays of them stay in L1
  struct Tile {
    alignas(64) double value[kTile];
  };
  using Floats [[gnu::vector_size(sizeof(V) / 2), gnu::may_alias, gnu::aligned(4)]] = float;

  [[gnu::always_inline]] static V widen(const float* from) noexcept {
    return __builtin_convertvector(*reinterpret_cast<const Floats*>(from), V);
  }
  /// Calls wide(i) for whole groups of lanes, one(i) for the elements after them.
  template <class Wide, class One>
  [[gnu::always_inline]] static void over(std::size_t count, const Wide& wide,
                                          const One& one) noexcept {
    std::size_t i = 0;
    for (; i + kLanes <= count; i += kLanes)
      for (std::size_t r = 0; r < kRegisters; ++r)
        wide(i + r * kWidth, r);
    for (; i < count; ++i)
      one(i);
  }

  /// to = stress + sum of terms.
  static void evaluate(const FeedbackTask& task, std::size_t first, std::size_t count,
                       Tile& to) noexcept {
    const float* stress = task.stress.data() + first;
    over(
        count, [&](std::size_t i, std::size_t) { store(to.value + i, widen(stress + i)); },
        [&](std::size_t i) { to.value[i] = stress[i]; });
    std::size_t t = 0;
    for (; t + 4 <= task.terms.size(); t += 4) {
      const TaylorTerm* term = task.terms.data() + t;
      const float *a = term[0].row + first, *b = term[1].row + first, *c = term[2].row + first,
                  *d = term[3].row + first;
      const V da = all(term[0].displacement_m), db = all(term[1].displacement_m),
              dc = all(term[2].displacement_m), dd = all(term[3].displacement_m);
      over(
          count,
          [&](std::size_t i, std::size_t) {
            store(to.value + i, load(to.value + i) + ((da * widen(a + i) + db * widen(b + i)) +
                                                      (dc * widen(c + i) + dd * widen(d + i))));
          },
          [&](std::size_t i) {
            to.value[i] += (term[0].displacement_m * static_cast<double>(a[i]) +
                            term[1].displacement_m * static_cast<double>(b[i])) +
                           (term[2].displacement_m * static_cast<double>(c[i]) +
                            term[3].displacement_m * static_cast<double>(d[i]));
          });
    }
    for (; t < task.terms.size(); ++t) {
      const TaylorTerm& term = task.terms[t];
      const float* row = term.row + first;
      const V displacement = all(term.displacement_m);
      over(
          count,
          [&](std::size_t i, std::size_t) {
            store(to.value + i, load(to.value + i) + displacement * widen(row + i));
          },
          [&](std::size_t i) { to.value[i] += term.displacement_m * static_cast<double>(row[i]); });
    }
  }

  [[gnu::always_inline]] static V smaller(V a, V b) noexcept {
#if defined(__SSE2__)
    if constexpr (sizeof(V) == 16)
      return _mm_min_pd(a, b);
#endif
#if defined(__AVX2__)
    if constexpr (sizeof(V) == 32)
      return _mm256_min_pd(a, b);
#endif
    return a < b ? a : b;
  }
  [[gnu::always_inline]] static V larger(V a, V b) noexcept { return -smaller(-a, -b); }
  /// |h| or h.
  [[gnu::always_inline]] static V sensitivity(const float* from, bool absolute) noexcept {
    const V value = widen(from);
    return absolute ? larger(value, -value) : value;
  }
  [[gnu::always_inline]] static double one_sensitivity(float value, bool absolute) noexcept {
    return static_cast<double>(absolute && value < 0 ? -value : value);
  }

  /// to = sum over the given axes of |h| or h.
  static void add_sensitivities(std::span<const float* const> axes, std::size_t first,
                                bool absolute, std::size_t count, Tile& to) noexcept {
    bool empty = true;
    for (const float* axis : axes) {
      if (!axis)
        continue;
      const float* h = axis + first;
      over(
          count,
          [&](std::size_t i, std::size_t) {
            const V value = sensitivity(h + i, absolute);
            store(to.value + i, empty ? value : load(to.value + i) + value);
          },
          [&](std::size_t i) {
            const double value = one_sensitivity(h[i], absolute);
            to.value[i] = empty ? value : to.value[i] + value;
          });
      empty = false;
    }
    if (empty)
      std::fill_n(to.value, count, 0.0);
  }

  /// x^q by squaring; x: V or double.
  template <class X> [[gnu::always_inline]] static X to_power(X x, X one, unsigned q) noexcept {
    X result = one;
    for (; q > 1; q >>= 1) {
      if (q & 1)
        result = result * x;
      x = x * x;
    }
    return result * x;
  }

  /// Sum of weight times value, and extremes of value: wide(i) in vectors, one(i) after them.
  template <class Wide, class One>
  [[gnu::always_inline]] static void reduce(const Wide& wide, const One& one, const float* weight,
                                            std::size_t count, Extremes& result) noexcept {
    V sum[kRegisters] = {}, low[kRegisters], high[kRegisters];
    for (std::size_t r = 0; r < kRegisters; ++r) {
      low[r] = all(result.min);
      high[r] = all(-result.max);
    }
    double rest = 0;
    over(
        count,
        [&](std::size_t i, std::size_t r) {
          const V value = wide(i);
          sum[r] += weight ? widen(weight + i) * value : value;
          low[r] = smaller(value, low[r]);
          high[r] = smaller(-value, high[r]);
        },
        [&](std::size_t i) {
          const double value = one(i);
          rest += weight ? static_cast<double>(weight[i]) * value : value;
          result.min = std::min(result.min, value);
          result.max = std::max(result.max, value);
        });
    result.sum += across(sum) + rest;
    for (std::size_t r = 0; r < kRegisters; ++r)
      for (std::size_t lane = 0; lane < kWidth; ++lane) {
        result.min = std::min(result.min, low[r][lane]);
        result.max = std::max(result.max, -high[r][lane]);
      }
  }

  static void add_powers(const FeedbackTask& task, const Tile& stress, const float* weight,
                         std::size_t count, Extremes& result) noexcept {
    const double per_scale = 1 / task.scale_pa;
    const V factor = all(per_scale), zero = all(0.0), limit = all(kMaxShare), one = all(1.0);
    reduce(
        [&](std::size_t i) {
          const V share = larger(smaller(load(stress.value + i) * factor, limit), zero);
          return to_power(share, one, task.power);
        },
        [&](std::size_t i) {
          return to_power(std::clamp(stress.value[i] * per_scale, 0.0, kMaxShare), 1.0, task.power);
        },
        weight, count, result);
  }

public:
  [[nodiscard]] FeedbackSums run(const FeedbackTask& task) const noexcept override {
    FeedbackSums result;
    Tile stress, h;
    const bool weighted = task.mapping == Mapping::kWeighted;
    const double share = weighted ? 1.0 / 3.0 : 1.0;
    const V part = all(share);
    for (std::size_t first = 0; first < task.stress.size(); first += kTile) {
      const std::size_t count = std::min(kTile, task.stress.size() - first);
      const float* weight = task.weight ? task.weight + first : nullptr;
      evaluate(task, first, count, stress);
      reduce([&](std::size_t i) { return load(stress.value + i); },
             [&](std::size_t i) { return stress.value[i]; }, weight, count, result.stress);
      if (task.mapping == Mapping::kMean) {
        if (task.power > 1)
          add_powers(task, stress, weight, count, result.power);
        continue;
      }
      for (std::size_t axis = 0; axis < (weighted ? 1 : 3); ++axis) {
        add_sensitivities(std::span(task.h).subspan(axis, weighted ? 3 : 1), first, task.absolute,
                          count, h);
        reduce([&](std::size_t i) { return load(h.value + i) * part * load(stress.value + i); },
               [&](std::size_t i) { return h.value[i] * share * stress.value[i]; }, weight, count,
               result.product[axis]);
      }
    }
    return result;
  }
};

} // namespace tactus::stress
