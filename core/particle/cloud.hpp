#pragma once

#include "core/dsp/random.hpp"
#include "core/particle/bubble_bank.hpp"
#include "core/particle/energy_store.hpp"
#include "core/particle/grain_bank.hpp"
#include "core/particle/poisson_clock.hpp"
#include "core/particle/power_law.hpp"
#include "core/particle/rustle.hpp"

#include <cstdint>

namespace tactus::particle {

/// What an aggregate's grains are like. Defaults are a neutral crunch.
struct CloudSettings {
  enum class Kind { kGrains, kBubbles, kRustle };
  Kind kind = Kind::kGrains;
  double count = 200;         ///< events for each unit of energy put in
  double attack_s = 0.01;     ///< in which a blow's energy arrives
  double decay_s = 0.05;      ///< in which the energy dies down
  double exponent = 1.5;      ///< of the events' energies: density ~ e^-(exponent + 1)
  double largest = 100;       ///< event energy over the smallest's
  double frequency_hz = 1500; ///< median of the grains' frequencies
  double spread = 0.8;        ///< standard deviation of their logarithm
  double lower_by_size = 0;   ///< frequency ~ event energy^-this: big grains sound lower
  double quality = 1;         ///< median; its logarithm varies by 0.2
  double length_s = 0.004;    ///< median of a grain's decay; its logarithm varies by 0.4
  double rise = 0.1;          ///< of bubbles: how far their pitch rises while they decay
  double level = 1;           ///< strength of the sound
};

/// Many small events from one store of energy (PhISEM; Cook 1997), with true statistics: a Poisson
/// process of rate count * E / decay, so that every unit of energy put in causes `count` events on
/// average at any sample rate; event energies from a power law; amplitude ~ sqrt(event energy * E).
/// A grain's strength is the square root of its energy, so the level is the same at any rate, too.
/// A rustle is the limit of countless grains: noise of the power level^2 E^2 / decay, which is what
/// grains of the same level have on average.
class Cloud {
public:
  void prepare(double sample_rate) noexcept;
  void set(const CloudSettings& settings) noexcept;
  /// Scales frequency, decay and level from now on: no two steps are alike.
  void vary(double frequency, double decay, double level) noexcept;
  void reset() noexcept;
  void seed(std::uint64_t value) noexcept { random_.seed(value); }

  void add_energy(double energy) noexcept { store_.add_energy(energy); }
  /// One sample: energy at that power (1/s) goes in, the sound comes out.
  double next(double power) noexcept;
  /// Sum over the last sample's events of sqrt(event energy * E), scaled so that `level` times it
  /// is the sum of their strengths. A rustle has no single events: 0.
  [[nodiscard]] double impulse() const noexcept { return impulse_; }
  /// The sum of their squares: the strength, squared, of many that come from all sides.
  [[nodiscard]] double impulse_squared() const noexcept { return impulse_squared_; }
  /// Nothing sounds and nothing will before more energy comes.
  [[nodiscard]] bool silent() const noexcept {
    return store_.empty() && grains_.sounding() == 0 && bubbles_.sounding() == 0;
  }
  [[nodiscard]] double energy() const noexcept { return store_.energy(); }
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }

private:
  void event() noexcept;
  void tune_rustle() noexcept;
  void set_store() noexcept;

  CloudSettings settings_;
  double sample_rate_ = 48000;
  double frequency_factor_ = 1, decay_factor_ = 1, level_factor_ = 1;
  double root_decay_ = 1;                    ///< of the store's decay time, s^(1/2)
  double expected_ = 0;                      ///< events in a sample for an energy of 1
  double normal_ = 1;                        ///< sets events of mean energy to strength 1
  double impulse_ = 0, impulse_squared_ = 0; ///< of the last sample
  std::uint64_t events_ = 0;
  Random random_;
  EnergyStore store_;
  PoissonClock clock_;
  PowerLaw energies_;
  GrainBank grains_;
  BubbleBank bubbles_;
  Rustle rustle_;
};

} // namespace tactus::particle
