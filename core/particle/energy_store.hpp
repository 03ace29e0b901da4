#pragma once

#include <algorithm>
#include <cmath>

namespace tactus::particle {

/// What is left of the energy that went into an aggregate: E' = -E / decay + power, solved exactly
/// over a sample in which the power is constant. Blows enter through a first-order delay, so that
/// they arrive within about `attack` seconds: a foot does not sink in at once.
/// E is in units of its input; Cook 1997 (PhISEM) multiplies by a constant each sample instead, so
/// that his decay changes with the sample rate.
class EnergyStore {
public:
  /// attack and decay in s, held within 1e-5..60.
  void set(double sample_rate, double attack_s, double decay_s) noexcept {
    attack_s_ = std::clamp(attack_s, 1e-5, 60.0);
    decay_s_ = std::clamp(decay_s, 1e-5, 60.0);
    const double step_s = 1 / sample_rate;
    decay_factor_ = std::exp(-step_s / decay_s_);
    attack_factor_ = std::exp(-step_s / attack_s_);
    release_rate_ = (1 - attack_factor_) * sample_rate;
    energy_per_power_ = decay_s_ * (1 - decay_factor_);
  }

  void reset() noexcept { energy_ = pending_ = 0; }

  /// Energy that arrives within the attack time.
  void add_energy(double energy) noexcept { pending_ += energy > 0 ? std::min(energy, 1e3) : 0; }

  /// One sample with that power (1/s) in addition; the energy at its end. Power is held within
  /// 0..1e6; what is no number is none.
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
  static constexpr double kEmptyThreshold = 1e-9; ///< below, the store is empty: no endless tail

  double attack_s_ = 0.01, decay_s_ = 0.1;
  double decay_factor_ = 0, attack_factor_ = 0;
  double release_rate_ = 0; ///< mean power of what arrives in a sample, for the energy pending, 1/s
  double energy_per_power_ = 0; ///< energy at the end of a sample for a power in it, s
  double energy_ = 0, pending_ = 0;
};

} // namespace tactus::particle
