#include "core/particle/particle_system.hpp"

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::particle {

namespace {

constexpr double kSmoothingS = 0.005;

} // namespace

void ParticleSystem::prepare(double sample_rate) noexcept {
  sample_rate_ = sample_rate;
  smoothing_step_ = 1 - math::exp(-1 / (kSmoothingS * sample_rate));
  fade_samples_ = std::max(1, static_cast<int>(kSmoothingS * sample_rate));
  fade_left_ = std::min(fade_left_, fade_samples_);
  cloud_.prepare(sample_rate);
  body_.prepare(sample_rate);
}

void ParticleSystem::set(const CloudSettings& settings) noexcept {
  settings_ = settings;
  cloud_.set(settings);
}

void ParticleSystem::set_body(std::span<const RingingMode> modes, double direct) noexcept {
  body_.set(modes);
  direct_ = direct;
}

void ParticleSystem::seed(std::uint64_t value) noexcept {
  seed_ = value;
  cloud_.seed(value);
  random_.seed(~value);
}

void ParticleSystem::shake(double energy) noexcept {
  if (fade_left_ > 0)
    pending_energy_ += energy > 0 ? std::min(energy, 1e3) : 0;
  else
    cloud_.add_energy(energy);
}

void ParticleSystem::reset() noexcept {
  pending_energy_ = 0;
  if (at_rest())
    silence();
  else if (fade_left_ == 0)
    fade_left_ = fade_samples_;
}

void ParticleSystem::silence() noexcept {
  fade_left_ = 0;
  cloud_.reset();
  body_.reset();
  seed(seed_);
  cloud_.add_energy(pending_energy_);
  pending_energy_ = 0;
}

double ParticleSystem::fade() noexcept {
  if (fade_left_ == 0)
    return 1;
  const double factor = static_cast<double>(fade_left_) / fade_samples_;
  if (--fade_left_ == 0)
    silence();
  return factor;
}

double ParticleSystem::body_sound() noexcept {
  if (body_.modes().empty())
    return body_.next(0);
  if (settings_.kind != CloudSettings::Kind::kRustle) {
    const double strength = settings_.level * std::sqrt(cloud_.impulse_squared());
    if (strength == 0)
      return body_.next(0);
    // Random signs: the collisions must add up neither to a static deflection nor in phase.
    return body_.next((random_.next() >> 63) != 0 ? strength : -strength);
  }
  const double energy = std::min(cloud_.energy(), 1e6);
  if (!(energy > 0))
    return body_.next(0);
  return body_.next(settings_.level * energy / std::sqrt(settings_.decay_s * sample_rate_) *
                    random_.normal());
}

ParticleSystem::Sample ParticleSystem::next(double power) noexcept {
  if (at_rest() && !(power > 0)) {
    smooth_gain_ = gain_;
    smooth_direct_ = direct_;
    if (fade_left_ > 0)
      silence();
    return {0, 0, 0};
  }
  smooth_gain_ += smoothing_step_ * (gain_ - smooth_gain_);
  smooth_direct_ += smoothing_step_ * (direct_ - smooth_direct_);
  const double grains = cloud_.next(power);
  const double sound = smooth_gain_ * (smooth_direct_ * grains + body_sound());
  // Read before fade(), which may silence the cloud.
  const double collisions = cloud_.impulse() * std::sqrt(std::max(settings_.count, 1e-3));
  const double energy = cloud_.energy();
  return {fade() * sound, collisions, energy};
}

} // namespace tactus::particle
