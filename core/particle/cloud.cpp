#include "core/particle/cloud.hpp"

#include "core/dsp/elementary.hpp"
#include "core/particle/cloud_rows.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::particle {

namespace {

/// Clamps to [lowest, highest]; NaN becomes `lowest`.
double clamped(double value, double lowest, double highest) noexcept {
  return value > lowest ? std::min(value, highest) : lowest;
}

} // namespace

void Cloud::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  grains_.prepare(sample_rate);
  bubbles_.prepare(sample_rate);
  rustle_.prepare(sample_rate);
  set(settings_);
}

void Cloud::set(const CloudSettings& settings) noexcept {
  settings_ = settings;
  for (const Parameter& row : kCloudRows)
    row.set(&settings_, clamped(row.get(&settings_), row.lowest, row.highest));
  set_store();
  energies_.set(settings_.exponent, settings_.largest);
  normalisation_ = 1 / std::sqrt(energies_.mean() * std::max(settings_.count, 1e-3));
  tune_rustle();
}

void Cloud::tune_rustle() noexcept {
  if (settings_.kind == CloudSettings::Kind::kRustle)
    rustle_.set(settings_.frequency_hz * frequency_factor_, settings_.spread, settings_.quality);
}

void Cloud::vary(double frequency, double decay, double level) noexcept {
  frequency_factor_ = clamped(frequency, 0.1, 10);
  decay_factor_ = clamped(decay, 0.1, 10);
  level_factor_ = clamped(level, 0, 100);
  set_store();
  tune_rustle();
}

void Cloud::set_store() noexcept {
  store_.set(sample_rate_, settings_.attack_s, settings_.decay_s * decay_factor_);
  root_decay_ = std::sqrt(store_.decay_s());
  expected_ = settings_.count / (store_.decay_s() * sample_rate_);
}

void Cloud::reset() noexcept {
  store_.reset();
  clock_.reset();
  grains_.reset();
  bubbles_.reset();
  rustle_.reset();
  impulse_ = impulse_squared_ = 0;
}

void Cloud::event() noexcept {
  ++events_;
  const double energy = energies_.draw(random_);
  const double size = std::sqrt(energy * std::min(store_.energy(), 1e6));
  const double strength = settings_.level * level_factor_ * normalisation_ * size;
  impulse_ += normalisation_ * size;
  impulse_squared_ += normalisation_ * normalisation_ * size * size;
  const double frequency = settings_.frequency_hz * frequency_factor_ *
                           math::exp(settings_.spread * random_.normal()) *
                           math::pow(energy, -settings_.lower_by_size);
  if (settings_.kind == CloudSettings::Kind::kBubbles) {
    // A tone a exp(-d t) sin has the energy a^2 / (4 d); as loud as a grain of that strength.
    const double radius = 3 / std::clamp(frequency, 20.0, 20000.0);
    const double amplitude = strength * std::sqrt(4 * bubble_decay_per_s(radius));
    bubbles_.start(radius, amplitude, settings_.rise);
    return;
  }
  grains_.start({frequency, settings_.quality * math::exp(0.2 * random_.normal()),
                 settings_.length_s * math::exp(0.4 * random_.normal()), strength},
                random_);
}

double Cloud::next(double power) noexcept {
  const double energy = store_.advance(power);
  impulse_ = impulse_squared_ = 0;
  double sound = 0;
  if (settings_.kind != CloudSettings::Kind::kRustle) {
    clock_.advance(expected_ * energy, random_, [this](double) { event(); });
  } else if (!store_.empty()) {
    sound = settings_.level * level_factor_ * std::min(energy, 1e6) / root_decay_ *
            rustle_.next(random_);
  }
  // Grains and bubbles started before a change of kind decay.
  if (bubbles_.sounding() > 0)
    sound += bubbles_.next();
  if (grains_.sounding() > 0)
    sound += grains_.next();
  return sound;
}

} // namespace tactus::particle
