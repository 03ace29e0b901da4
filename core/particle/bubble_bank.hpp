#pragma once

#include <array>
#include <cstddef>

namespace tactus::particle {

/// Frequency of a bubble of that radius (m): 3 m/s over the radius, in Hz. Minnaert 1933 gives
/// 3.26 m/s for air in water at 1 atm; van den Doel 2005 takes 3.
[[nodiscard]] double bubble_frequency_hz(double radius_m) noexcept;
/// Amplitude decay in 1/s: radiation and heat, 0.13 / r + 0.0072 r^(-3/2) (van den Doel 2005).
[[nodiscard]] double bubble_decay_per_s(double radius_m) noexcept;

/// Bubbles under a water surface: damped tones that rise as the bubble rises,
/// a exp(-d t) sin(phase), phase' = 2 pi f (1 + rise d t). The phase is quadratic in time, so two
/// complex rotations a sample give it exactly.
class BubbleBank {
public:
  static constexpr std::size_t kMaxBubbles = 128; ///< bubbles at once; more are left out

  void prepare(double sample_rate) noexcept;
  void reset() noexcept { count_ = 0; }
  /// Radius in m, held within 0.15 mm..150 mm; rise 0..1 (0.1 is common).
  void start(double radius_m, double amplitude, double rise) noexcept;
  double next() noexcept;
  [[nodiscard]] std::size_t sounding() const noexcept { return count_; }

private:
  struct Bubble {
    double real, imaginary;                   ///< of a exp(-d t + j phase)
    double rotation_real, rotation_imaginary; ///< to the next sample
    double chirp_real, chirp_imaginary;       ///< of the turn, to its next
    long samples_left;
  };
  double sample_rate_ = 48000;
  std::size_t count_ = 0;
  std::array<Bubble, kMaxBubbles> bubbles_{};
};

} // namespace tactus::particle
