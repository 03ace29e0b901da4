#pragma once

#include "core/dsp/random.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::particle {

/// One grain: white noise with the envelope exp(-t / length), through a two-pole band-pass.
struct Grain {
  double frequency_hz = 1000; ///< centre of the band-pass, clamped to 10 Hz..0.45 sample rate
  double quality = 1;         ///< Q of the band-pass
  double length_s = 0.004;    ///< time constant of the envelope
  double strength = 1; ///< square root of the expected integral of the squared sound, s^(1/2)
};

/// Plays many grains at once, each with its own frequency, quality and noise.
///
/// The expected energy of a grain is strength^2 at any sample rate. Noise, envelope and filter are
/// independent, so the energy is noise variance times the sum of envelope^2 times the sum of h^2,
/// with the impulse response h. For the bilinear band-pass the sum of h^2 is a / (1 + a), a =
/// sin(w) / (2 Q), w = 2 pi frequency / sample rate.
class GrainBank {
public:
  static constexpr std::size_t kMaxGrains = 256; ///< simultaneous grains; further ones are dropped

  /// A new sample rate, Hz, ends all grains.
  void prepare(double sample_rate) noexcept;
  void reset() noexcept;
  /// Starts a grain; `random` seeds its noise.
  void start(const Grain& grain, Random& random) noexcept;
  /// One sample of the sum of all grains.
  double next() noexcept;
  /// Number of grains that sound.
  [[nodiscard]] std::size_t sounding() const noexcept { return count_; }

private:
  static constexpr unsigned kCheckInterval = 32; ///< samples between two removals of ended grains
  void remove_ended() noexcept;

  double sample_rate_ = 48000;
  std::size_t count_ = 0;
  unsigned until_check_ = kCheckInterval;
  // One array per quantity, so that the compiler vectorises the loop over grains.
  std::array<double, kMaxGrains> envelope_{}, decay_factor_{}, gain_{}, a1_{}, a2_{};
  std::array<double, kMaxGrains> x1_{}, x2_{}, y1_{}, y2_{}, sound_{};
  std::array<std::uint32_t, kMaxGrains> noise_{};
  std::array<std::int32_t, kMaxGrains> samples_left_{};
};

} // namespace tactus::particle
