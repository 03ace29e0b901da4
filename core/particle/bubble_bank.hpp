#pragma once

#include <array>
#include <cstddef>

namespace tactus::particle {

/// Frequency f of an air bubble of radius r in water, Hz: f = (3 m/s)/r (van den Doel 2005;
/// Minnaert 1933 gives 3.26 m/s at 1 atm).
[[nodiscard]] double bubble_frequency_hz(double radius_m) noexcept;
/// Decay rate d of the amplitude by radiation and heat loss, 1/s: d = 0.13/r + 0.0072 r^(-3/2), r
/// in m (van den Doel 2005).
[[nodiscard]] double bubble_decay_per_s(double radius_m) noexcept;

/// Plays the tones of many bubbles under a water surface. Each is a damped sine whose frequency
/// rises as the bubble does (van den Doel 2005), of phase' = 2 pi f (1 + rise d t).
///
/// A bubble's pressure is rho/(4 pi distance) times the rate of its volume flow, which is 0 before
/// and after the bubble: the pressure has no mean. The flow (a/phase') exp(-d t) (1 - cos(phase))
/// gives
///     p = a exp(-d t) (sin(phase) - k (1 - cos(phase))),   k = d/phase' + phase''/phase'^2,
/// the damped sine and a term that removes its mean, smaller by the factor d/phase' (some
/// hundredths). The phase is quadratic in time, so two complex rotations per sample compute it
/// exactly.
class BubbleBank {
public:
  static constexpr std::size_t kMaxBubbles = 128; ///< simultaneous bubbles; further ones are
                                                  ///< dropped

  /// A new sample rate, Hz, ends all bubbles.
  void prepare(double sample_rate) noexcept;
  void reset() noexcept { count_ = 0; }
  /// Starts a bubble. Radius clamped to 0.15 mm..150 mm; rise to 0..1 (0.1 is common). Bubbles
  /// above 0.45 of the sample rate are dropped.
  void start(double radius_m, double amplitude, double rise) noexcept;
  /// One sample of the sum of all bubbles.
  double next() noexcept;
  /// Number of bubbles that sound.
  [[nodiscard]] std::size_t sounding() const noexcept { return count_; }

private:
  struct Bubble {
    double real, imaginary;                   ///< state a exp(-d t + j phase)
    double envelope, decay_factor;            ///< a exp(-d t), and its factor from a sample to the
                                              ///< next
    double pitch, pitch_step;                 ///< 1 + rise d t, and its increment from a sample to
                                              ///< the next
    double flow, chirp_flow;                  ///< k is flow/pitch + chirp_flow/pitch^2
    double rotation_real, rotation_imaginary; ///< factor from this sample to the next
    double chirp_real, chirp_imaginary;       ///< factor from this rotation to the next
    long samples_left;
  };
  double sample_rate_ = 48000;
  std::size_t count_ = 0;
  std::array<Bubble, kMaxBubbles> bubbles_{};
};

} // namespace tactus::particle
