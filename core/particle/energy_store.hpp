#pragma once

#include "core/dsp/elementary.hpp"

#include <algorithm>

namespace tactus::particle {

/// Energy E of an aggregate of particles that is driven and loses energy by collisions:
///     E' = -E / decay + power,
/// solved exactly over a sample of constant power. Energy that arrives at once, add_energy(),
/// passes through a first-order low-pass of time constant `attack`: a foot sinks in gradually. E
/// has the unit of its input. Cook 1997 (PhISEM) multiplies E by a constant every sample instead,
/// so his decay depends on the sample rate.
class EnergyStore {
public:
  /// Time constants in s, clamped to 1e-5..60.
  void set(double sample_rate, double attack_s, double decay_s) noexcept {
    attack_s_ = std::clamp(attack_s, 1e-5, 60.0);
    decay_s_ = std::clamp(decay_s, 1e-5, 60.0);
    const double step_s = 1 / sample_rate;
    decay_factor_ = math::exp(-step_s / decay_s_);
    attack_factor_ = math::exp(-step_s / attack_s_);
    release_rate_ = (1 - attack_factor_) * sample_rate;
    energy_per_power_ = decay_s_ * (1 - decay_factor_);
  }

  void reset() noexcept { energy_ = pending_ = 0; }

  /// Adds energy, clamped to 0..1000, that arrives with the attack's time constant.
  void add_energy(double energy) noexcept { pending_ += energy > 0 ? std::min(energy, 1e3) : 0; }

  /// Advances by a sample, with this additional power, 1/s. Returns the energy at the end of the
  /// sample. Power is clamped to 0..1e6; NaN counts as 0.
  double advance(double power) noexcept {
    power = power > 0 ? std::min(power, 1e6) : 0;
    power += pending_ * release_rate_;
    pending_ *= attack_factor_;
    energy_ = energy_ * decay_factor_ + power * energy_per_power_;
    if (energy_ + pending_ < kEmptyThreshold)
      energy_ = pending_ = 0;
    return energy_;
  }

  [[nodiscard]] double energy() const noexcept { return energy_; }
  [[nodiscard]] double decay_s() const noexcept { return decay_s_; }
  [[nodiscard]] bool empty() const noexcept { return energy_ + pending_ == 0; }

private:
  static constexpr double kEmptyThreshold = 1e-9; ///< energy below it is set to 0

  double attack_s_ = 0.01, decay_s_ = 0.1;
  double decay_factor_ = 0, attack_factor_ = 0;
  double release_rate_ = 0;     ///< mean power of the energy that arrives in a sample, per pending
                                ///< energy, 1/s
  double energy_per_power_ = 0; ///< energy at the end of a sample per power in that sample, s
  double energy_ = 0, pending_ = 0; ///< pending_: not yet arrived
};

} // namespace tactus::particle
