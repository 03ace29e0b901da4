#pragma once

#include "core/dsp/elementary.hpp"

#include <array>
#include <cmath>
#include <cstdint>

namespace tactus {

/// Pseudo-random number generator whose integers are the same on every platform: xoshiro256++
/// (Blackman & Vigna 2021), period 2^256 - 1. splitmix64 fills its state from the seed, so that
/// neighbouring seeds give unrelated streams.
class Random {
public:
  explicit Random(std::uint64_t seed_value = 1) noexcept { seed(seed_value); }

  void seed(std::uint64_t value) noexcept {
    for (auto& word : state_) {
      value += 0x9e3779b97f4a7c15ULL;
      std::uint64_t z = value;
      z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
      z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
      word = z ^ (z >> 31);
    }
    has_spare_ = false;
  }

  std::uint64_t next() noexcept {
    const std::uint64_t result = rotate(state_[0] + state_[3], 23) + state_[0];
    const std::uint64_t shifted = state_[1] << 17;
    state_[2] ^= state_[0];
    state_[3] ^= state_[1];
    state_[1] ^= state_[2];
    state_[0] ^= state_[3];
    state_[2] ^= shifted;
    state_[3] = rotate(state_[3], 45);
    return result;
  }

  /// Uniform in [0, 1), 53 random bits.
  double uniform() noexcept { return static_cast<double>(next() >> 11) * 0x1.0p-53; }

  /// Normal, mean 0, variance 1 (Marsaglia & Bray's polar method, which makes two values at a
  /// time). 1.27 iterations on average; after 64 (probability 1e-43) it returns 0. Always inline,
  /// because files compiled for newer processors use it and must not emit a shared copy.
  [[gnu::always_inline]] double normal() noexcept {
    if (has_spare_) {
      has_spare_ = false;
      return spare_;
    }
    for (int round = 0; round < 64; ++round) {
      const double a = 2.0 * uniform() - 1.0;
      const double b = 2.0 * uniform() - 1.0;
      const double square = a * a + b * b;
      if (square > 0.0 && square < 1.0) {
        const double scale = std::sqrt(-2.0 * math::log(square) / square);
        spare_ = b * scale;
        has_spare_ = true;
        return a * scale;
      }
    }
    return 0.0;
  }

private:
  static std::uint64_t rotate(std::uint64_t word, int bits) noexcept {
    return (word << bits) | (word >> (64 - bits));
  }

  std::array<std::uint64_t, 4> state_{};
  double spare_ = 0;
  bool has_spare_ = false;
};

} // namespace tactus
