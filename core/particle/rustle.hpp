#pragma once

#include "core/dsp/random.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::particle {

/// So many small grains that nobody hears one of them: by Campbell's theorem (Rice 1944) the sum of
/// a Poisson process tends to Gaussian noise with the grains' mean spectrum. Six band-passed noises
/// at the middles of six equally likely parts of a log-normal distribution of frequencies stand for
/// that spectrum, at a cost that does not grow with the number of grains.
class Rustle {
public:
  void prepare(double sample_rate) noexcept { sample_rate_ = sample_rate; }
  /// Median frequency in Hz, held within 10 Hz and 0.45 of the sample rate for each band; standard
  /// deviation of the logarithm; quality of each band-pass.
  void set(double frequency_hz, double spread, double quality) noexcept;
  void reset() noexcept;
  /// One sample of noise of variance 1 at any sample rate.
  double next(Random& random) noexcept;

private:
  static constexpr std::size_t kBands = 6;

  double sample_rate_ = 48000;
  std::array<double, kBands> gain_{}, a1_{}, a2_{}, x1_{}, x2_{}, y1_{}, y2_{};
  std::array<std::uint32_t, kBands> noise_{};
};

} // namespace tactus::particle
