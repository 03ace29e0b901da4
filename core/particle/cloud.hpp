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

/// Parameters of the particles of an aggregate. The defaults are a neutral crunch.
struct CloudSettings {
  enum class Kind { kGrains, kBubbles, kRustle };
  Kind kind = Kind::kGrains;
  double count = 200;         ///< events per unit of energy put in
  double attack_s = 0.01;     ///< time constant with which added energy arrives
  double decay_s = 0.05;      ///< time constant with which the energy decays
  double exponent = 1.5;      ///< exponent of the event energies: density ~ e^-(exponent + 1)
  double largest = 100;       ///< largest event energy over the smallest
  double frequency_hz = 1500; ///< median frequency of the grains
  double spread = 0.8;        ///< standard deviation of the logarithm of the frequency
  double lower_by_size = 0;   ///< frequency ~ event energy^-this: large grains sound lower
  double quality = 1;         ///< median Q; standard deviation of its logarithm: 0.2
  double length_s = 0.004;    ///< median length of the grains; standard deviation of its logarithm:
                              ///< 0.4
  double rise = 0.1;          ///< relative rise of a bubble's frequency in the time 1/d
  double level = 1;           ///< strength of the sound
};

/// Many small sound events driven by one store of energy E (PhISEM; Cook 1997).
///
/// Events are a Poisson process of rate count E / decay. So each unit of energy causes `count`
/// events on average, at any sample rate. Event energies follow a power law; the amplitude of an
/// event is ~ sqrt(event energy E). A grain's strength is the square root of its energy, so the
/// level does not depend on the sample rate either.
///
/// A rustle is the limit of many grains: noise of power level^2 E^2 / decay, the mean power of
/// grains of the same level.
class Cloud {
public:
  /// Sample rate in Hz.
  void prepare(double sample_rate) noexcept;
  /// Settings out of range are clamped; NaN counts as the lowest value.
  void set(const CloudSettings& settings) noexcept;
  /// Factors on frequency, decay and level of the settings, for variation from step to step. They
  /// stay until they are changed, and are clamped to 0.1..10, 0.1..10 and 0..100.
  void vary(double frequency, double decay, double level) noexcept;
  void reset() noexcept;
  /// Also redraws the next event and the rustle's noise, so that all later output depends on the
  /// seed alone.
  void seed(std::uint64_t value) noexcept {
    random_.seed(value);
    clock_.reset();
    rustle_.redraw();
  }

  /// EnergyStore::add_energy().
  void add_energy(double energy) noexcept { store_.add_energy(energy); }
  /// One sample of sound, while energy arrives with this power, 1/s.
  double next(double power) noexcept;
  /// Sum over the events of the last sample of sqrt(event energy E), scaled so that `level` times
  /// the sum is the sum of their strengths. 0 for a rustle, which has no single events.
  [[nodiscard]] double impulse() const noexcept { return impulse_; }
  /// Sum over these events of the squares: the squared strength of events with random signs.
  [[nodiscard]] double impulse_squared() const noexcept { return impulse_squared_; }
  /// True if nothing sounds and no event will follow before energy arrives.
  [[nodiscard]] bool silent() const noexcept {
    return store_.empty() && grains_.sounding() == 0 && bubbles_.sounding() == 0;
  }
  [[nodiscard]] double energy() const noexcept { return store_.energy(); }
  /// Number of events so far.
  [[nodiscard]] std::uint64_t events() const noexcept { return events_; }

private:
  void event() noexcept;
  void tune_rustle() noexcept;
  void set_store() noexcept;

  CloudSettings settings_;
  double sample_rate_ = 48000;
  double frequency_factor_ = 1, decay_factor_ = 1, level_factor_ = 1;
  double root_decay_ = 1;                    ///< square root of the store's decay time, s^(1/2)
  double expected_ = 0;                      ///< mean number of events in a sample at E = 1
  double normalisation_ = 1;                 ///< 1/sqrt(mean event energy count)
  double impulse_ = 0, impulse_squared_ = 0; ///< impulses of the last sample
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
