#include "bench/modal_bank/bare.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>
#include <vector>

#if defined(__x86_64__)
#include <immintrin.h>

namespace {

using tactus::modal::VectorSet;

struct Avx2 {
  using V = __m256;
  static constexpr std::size_t width = 8, flight = 4; // 16 registers: four modes' worth of each
};
struct Avx512 {
  using V = __m512;
  static constexpr std::size_t width = 16, flight = 6;
};

struct alignas(64) Sixteen {
  float v[16];
};

/// Coefficients and states of the recursion, padded to whole groups of registers in flight.
struct Modes {
  explicit Modes(std::size_t count, std::size_t group)
      : padded((count + group - 1) / group * group), square(padded / 16 + 1), kappa(square.size()),
        gain(square.size()), speed(square.size()), displacement(square.size()) {
    for (std::size_t k = 0; k < count; ++k) {
      const double r = std::exp(-2.0 / 48000),
                   w = 2 * std::numbers::pi / 48000 *
                       (50 + 20000.0 * static_cast<double>(k) / static_cast<double>(count));
      square[k / 16].v[k % 16] = static_cast<float>(r * r);
      kappa[k / 16].v[k % 16] = static_cast<float>(1 + r * r - 2 * r * std::cos(w));
      gain[k / 16].v[k % 16] = 1;
    }
  }
  std::size_t padded;
  std::vector<Sixteen> square, kappa, gain, speed, displacement;
};

// The two bodies are one text for both instruction sets: a function is compiled for the set that
// its attribute names.
#define TACTUS_BARE_BLOCK(NAME, SET, TARGET, LOAD, STORE, FMADD, FNMADD, ALL, ADD, SUM)            \
  [[gnu::target(TARGET)]] void NAME(Modes& m, const float* in, float* out) {                       \
    using V = SET::V;                                                                              \
    constexpr std::size_t kFlight = SET::flight, kWidth = SET::width;                              \
    alignas(64) V sum[64];                                                                         \
    for (auto& s : sum)                                                                            \
      s = ALL(0.0F);                                                                               \
    for (std::size_t at = 0; at < m.padded; at += kFlight * kWidth) {                              \
      V square[kFlight], kappa[kFlight], gain[kFlight], speed[kFlight], displacement[kFlight];     \
      for (std::size_t r = 0; r < kFlight; ++r) {                                                  \
        const std::size_t i = at + r * kWidth;                                                     \
        square[r] = LOAD(m.square[0].v + i);                                                       \
        kappa[r] = LOAD(m.kappa[0].v + i);                                                         \
        gain[r] = LOAD(m.gain[0].v + i);                                                           \
        speed[r] = LOAD(m.speed[0].v + i);                                                         \
        displacement[r] = LOAD(m.displacement[0].v + i);                                           \
      }                                                                                            \
      for (std::size_t n = 0; n < 64; ++n) {                                                       \
        const V x = ALL(in[n]);                                                                    \
        V s = sum[n];                                                                              \
        for (std::size_t r = 0; r < kFlight; ++r) {                                                \
          speed[r] = FMADD(square[r], speed[r],                                                    \
                           FNMADD(kappa[r], displacement[r], FMADD(gain[r], x, ALL(0.0F))));       \
          displacement[r] = ADD(displacement[r], speed[r]);                                        \
          s = ADD(s, displacement[r]);                                                             \
        }                                                                                          \
        sum[n] = s;                                                                                \
      }                                                                                            \
      for (std::size_t r = 0; r < kFlight; ++r) {                                                  \
        STORE(m.speed[0].v + at + r * kWidth, speed[r]);                                           \
        STORE(m.displacement[0].v + at + r * kWidth, displacement[r]);                             \
      }                                                                                            \
    }                                                                                              \
    for (std::size_t n = 0; n < 64; ++n)                                                           \
      out[n] = SUM(sum[n]);                                                                        \
  }

[[gnu::target("avx512f,avx2,fma")]] float sum_of(__m512 v) {
  alignas(64) float x[16];
  _mm512_store_ps(x, v);
  float sum = 0;
  for (const float lane : x)
    sum += lane;
  return sum;
}
[[gnu::target("avx2,fma")]] float sum_of(__m256 v) {
  alignas(32) float x[8];
  _mm256_store_ps(x, v);
  return ((x[0] + x[1]) + (x[2] + x[3])) + ((x[4] + x[5]) + (x[6] + x[7]));
}

TACTUS_BARE_BLOCK(block_avx2, Avx2, "avx2,fma", _mm256_loadu_ps, _mm256_storeu_ps, _mm256_fmadd_ps,
                  _mm256_fnmadd_ps, _mm256_set1_ps, _mm256_add_ps, sum_of)
TACTUS_BARE_BLOCK(block_avx512, Avx512, "avx512f,avx2,fma", _mm512_loadu_ps, _mm512_storeu_ps,
                  _mm512_fmadd_ps, _mm512_fnmadd_ps, _mm512_set1_ps, _mm512_add_ps, sum_of)
#undef TACTUS_BARE_BLOCK

template <class Set, void (*Block)(Modes&, const float*, float*)> class Bare final : public Peer {
public:
  explicit Bare(std::size_t modes) : modes_(modes, Set::width * Set::flight * 2) {}
  void block(const float* in, float* out) override { Block(modes_, in, out); }

private:
  Modes modes_;
};

constexpr int kProducts = 400000;

[[gnu::target("avx2,fma")]] float products_avx2() {
  __m256 x[12], k = _mm256_set1_ps(0.999F);
  for (auto& v : x)
    v = k;
  for (int i = 0; i < kProducts; ++i) {
    asm volatile("" : "+x"(k));
#pragma GCC unroll 12
    for (auto& v : x)
      v = _mm256_fmadd_ps(v, k, k);
  }
  __m256 all = x[0];
  for (auto& v : x)
    all = _mm256_add_ps(all, v);
  return sum_of(all);
}

[[gnu::target("avx512f,avx2,fma")]] float products_avx512() {
  __m512 x[12], k = _mm512_set1_ps(0.999F);
  for (auto& v : x)
    v = k;
  for (int i = 0; i < kProducts; ++i) {
    asm volatile("" : "+v"(k));
#pragma GCC unroll 12
    for (auto& v : x)
      v = _mm512_fmadd_ps(v, k, k);
  }
  __m512 all = x[0];
  for (auto& v : x)
    all = _mm512_add_ps(all, v);
  return sum_of(all);
}

} // namespace

std::unique_ptr<Peer> make_bare_recursion(VectorSet set, std::size_t modes) {
  if (set == VectorSet::kBaseline || !tactus::simd::runs(set))
    return nullptr;
  if (set == VectorSet::kAvx2)
    return std::make_unique<Bare<Avx2, block_avx2>>(modes);
  return std::make_unique<Bare<Avx512, block_avx512>>(modes);
}

double multiply_adds_per_ns(VectorSet set) {
  if (set == VectorSet::kBaseline || !tactus::simd::runs(set))
    return 0;
  const bool wide = set == VectorSet::kAvx512;
  volatile float sink = 0;
  double maximum = 0;
  for (int round = 0; round < 20; ++round) {
    const auto begin = std::chrono::steady_clock::now();
    sink = wide ? products_avx512() : products_avx2();
    const double ns =
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - begin).count();
    maximum = std::max(maximum, 12.0 * kProducts * (wide ? 16 : 8) / ns);
  }
  static_cast<void>(sink);
  return maximum;
}

#else

std::unique_ptr<Peer> make_bare_recursion(tactus::modal::VectorSet, std::size_t) { return nullptr; }
double multiply_adds_per_ns(tactus::modal::VectorSet) { return 0; }

#endif
