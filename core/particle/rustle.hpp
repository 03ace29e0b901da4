#pragma once

#include "core/dsp/random.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::particle {

/// Noise that replaces a cloud of very many small grains, at a cost that does not grow with their
/// number. By Campbell's theorem (Rice 1944) the sum of a Poisson process of grains tends to
/// Gaussian noise with the mean spectrum of the grains. Six band-passed noises approximate that
/// spectrum; their frequencies are the medians of six equally probable parts of a log-normal
/// distribution.
class Rustle {
public:
  /// Sample rate in Hz; takes effect with the next set().
  void prepare(double sample_rate) noexcept { sample_rate_ = sample_rate; }
  /// Median frequency in Hz; standard deviation of its logarithm; Q of each band-pass. The
  /// frequency of each band is clamped to 10 Hz..0.45 of the sample rate.
  void set(double frequency_hz, double spread, double quality) noexcept;
  void reset() noexcept;
  /// The next sample draws the noise again from its `random`.
  void redraw() noexcept { noise_.fill(0); }
  /// One sample of noise of variance 1 at any sample rate.
  double next(Random& random) noexcept;

private:
  static constexpr std::size_t kBands = 6;

  double sample_rate_ = 48000;
  std::array<double, kBands> gain_{}, a1_{}, a2_{}, x1_{}, x2_{}, y1_{}, y2_{};
  std::array<std::uint32_t, kBands> noise_{};
};

} // namespace tactus::particle
