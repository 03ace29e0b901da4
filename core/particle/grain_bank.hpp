#pragma once

#include "core/dsp/random.hpp"

#include <array>
#include <cstddef>
#include <cstdint>

namespace tactus::particle {

/// One grain: white noise that decays as exp(-t / length), through a two-pole band-pass.
struct Grain {
  double frequency_hz = 1000; ///< centre of the band-pass, held below 0.45 of the sample rate
  double quality = 1;
  double length_s = 0.004;
  double strength = 1; ///< square root of the integral of the squared sound over time, expected
};

/// Many grains at once. Each has a frequency, a quality and a noise of its own: that is what tells
/// snow from a shaker. The strength is exact in expectation at any sample rate: noise, envelope and
/// filter are independent, so the energy is noise variance times the sum of envelope^2 times the
/// sum of h^2, and for the bilinear band-pass sum h^2 = a / (1 + a), a = sin(w) / (2 Q).
class GrainBank {
public:
  static constexpr std::size_t kMaxGrains = 256; ///< grains at once; more are left out

  void prepare(double sample_rate) noexcept;
  void reset() noexcept;
  void start(const Grain& grain, Random& random) noexcept;
  /// One sample of the sum of all grains.
  double next() noexcept;
  [[nodiscard]] std::size_t sounding() const noexcept { return count_; }

private:
  static constexpr unsigned kCheckInterval = 32; ///< samples between two searches for ended grains
  void remove_ended() noexcept;

  double sample_rate_ = 48000;
  std::size_t count_ = 0;
  unsigned until_check_ = kCheckInterval;
  // One array a quantity, so that the loop over grains is vectorised.
  std::array<double, kMaxGrains> envelope_{}, decay_factor_{}, gain_{}, a1_{}, a2_{};
  std::array<double, kMaxGrains> x1_{}, x2_{}, y1_{}, y2_{}, sound_{};
  std::array<std::uint32_t, kMaxGrains> noise_{};
  std::array<std::int32_t, kMaxGrains> samples_left_{}; ///< samples of life
};

} // namespace tactus::particle
