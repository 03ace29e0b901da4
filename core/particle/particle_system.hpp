#pragma once

#include "core/dsp/random.hpp"
#include "core/particle/cloud.hpp"
#include "core/particle/ringing_body.hpp"

#include <cstdint>
#include <span>

namespace tactus::particle {

/// A shaker: particles that collide while their system has energy, and the body that they strike.
/// PhISEM (Cook 1997) with the statistics of Cloud. The sound is
///     gain (direct cloud + sum over collisions of the body's response),
/// whose mean power at constant energy E, far from the limits of the banks, is
///     gain^2 (direct^2 + sum g_i^2) level^2 E^2 / decay.
/// E is relative: 1 is the energy of one ordinary shake or step. The collisions have random signs
/// on the body. A rustle excites the body by white noise with the power of collisions of the same
/// level.
class ParticleSystem {
public:
  struct Sample {
    double sound;
    double collisions; ///< sum of sqrt(e E / mean e) over the collisions; 0 for a rustle
    double energy;     ///< E
  };

  /// Sample rate in Hz.
  void prepare(double sample_rate) noexcept;
  /// Settings of the particles, clamped as Cloud::set() does.
  void set(const CloudSettings& settings) noexcept;
  /// Modes of the body, and the gain 0..1 of the direct sound of the particles. The gain is
  /// smoothed as in set_gain().
  void set_body(std::span<const RingingMode> modes, double direct) noexcept;
  /// Gain of the sound, smoothed with a time constant of 5 ms; takes effect at once during silence.
  void set_gain(double gain) noexcept { gain_ = gain; }
  void seed(std::uint64_t value) noexcept;
  /// Adds energy, clamped to 0..1000, that arrives with the attack's time constant.
  void shake(double energy) noexcept;
  /// Fades all sound out within 5 ms, then restarts the random sequence. The energy of shakes
  /// during the fade is added after it.
  void reset() noexcept;
  /// One sample, while energy arrives with this power, 1/s. NaN and negative power count as 0.
  Sample next(double power) noexcept;

  [[nodiscard]] bool at_rest() const noexcept { return cloud_.silent() && body_.at_rest(); }
  [[nodiscard]] double energy() const noexcept { return cloud_.energy(); }
  [[nodiscard]] std::uint64_t collisions() const noexcept { return cloud_.events(); }
  [[nodiscard]] std::span<const RingingMode> modes() const noexcept { return body_.modes(); }

private:
  [[nodiscard]] double body_sound() noexcept;
  double fade() noexcept;
  void silence() noexcept;

  CloudSettings settings_;
  Cloud cloud_;
  RingingBody body_;
  std::uint64_t seed_ = 1;
  Random random_; ///< signs of the collisions, and the noise by which a rustle excites the body
  double sample_rate_ = 48000;
  double direct_ = 1, smooth_direct_ = 1, gain_ = 1, smooth_gain_ = 1, smoothing_step_ = 1;
  int fade_samples_ = 240, fade_left_ = 0; ///< fade of a reset: length, and samples that remain
  double pending_energy_ = 0;              ///< energy of the shakes during a reset
};

} // namespace tactus::particle
