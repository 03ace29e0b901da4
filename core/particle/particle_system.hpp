#pragma once

#include "core/dsp/random.hpp"
#include "core/particle/cloud.hpp"
#include "core/particle/ringing_body.hpp"

#include <cstdint>
#include <span>

namespace tactus::particle {

/// Particles that collide while their system has energy, and the body that they strike: PhISEM
/// (Cook 1997) with the statistics of Cloud. The sound is
///   gain (direct cloud + sum over collisions of the body's ring),
/// whose mean power at constant energy E, far from its limits, is
///   gain^2 (direct^2 + sum g_i^2) level^2 E^2 / decay.
/// Collisions strike the body from either side, at random. E is relative: 1 is what one ordinary
/// shake or step brings. A rustle strikes the body with white noise of the power that collisions of
/// the same level have.
class ParticleSystem {
public:
  struct Sample {
    double sound;
    double
        collisions; ///< sum of sqrt(e E / mean e) over the sample's collisions; a rustle has none
    double energy;
  };

  void prepare(double sample_rate) noexcept;
  void set(const CloudSettings& settings) noexcept;
  /// Modes of the body struck, and the share of the grains that is heard beside it (0..1). The
  /// share moves as the gain does.
  void set_body(std::span<const RingingMode> modes, double direct) noexcept;
  /// Reached within some 15 ms (first order, 5 ms), at once while nothing sounds.
  void set_gain(double gain) noexcept { gain_ = gain; }
  void seed(std::uint64_t value) noexcept;
  /// That much energy, held within 0..1000, arrives within the attack time.
  void shake(double energy) noexcept;
  /// Silence: what sounds fades within 5 ms. Shakes meanwhile wait until then.
  void reset() noexcept;
  /// One sample at that power (1/s). No number and what is negative count as none.
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
  Random random_; ///< the sides that collisions come from, and what a rustle strikes the body with
  double sample_rate_ = 48000;
  double direct_ = 1, smooth_direct_ = 1, gain_ = 1, smooth_gain_ = 1, smoothing_step_ = 1;
  int fade_samples_ = 240, fade_left_ = 0; ///< of a reset under way
  double pending_energy_ = 0;              ///< energy of shakes that wait for it
};

} // namespace tactus::particle
