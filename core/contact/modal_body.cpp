#include "core/contact/modal_body.hpp"

#include "core/contact/power.hpp"
#include "core/dsp/complex.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::contact {
namespace {

constexpr double kMaxRateFraction = 0.49; // largest rate as a share of the sample rate
constexpr double kMinAmplitude = 1e-20;   // sqrt(J); a mode below it is set to 0
constexpr double kMaxAmplitude = 1e60;    // sqrt(J)
/// omega of a rigid motion, rad/s: within a second it changes the speed by a share below 1e-16.
constexpr double kRigidOmega = 1e-8;
constexpr double kSixtyDecibels = 6.907755278982137; // ln 1000

/// P - 1 = e^(s h) - 1 and B = (P - 1)/s.
struct Step {
  Complex change, response;
};
Step step_of(Complex rate, double h) noexcept {
  const Complex x = rate * h;
  if (math::abs(x) < 0.1) { // (e^x - 1)/x = sum of x^n/(n + 1)!, without cancellation
    Complex sum = 0;
    for (int n = 10; n >= 0; --n)
      sum = 1.0 + x / static_cast<double>(n + 2) * sum;
    return {x * sum, h * sum};
  }
  const double radius = math::exp(x.real()), sine = math::sin(0.5 * x.imag());
  const Complex change{math::expm1(x.real()) - 2 * radius * sine * sine,
                       radius * math::sin(x.imag())};
  return {change, change / rate};
}

} // namespace

ModalBody::ModalBody(std::size_t max_modes)
    : real(max_modes), imaginary(max_modes), displacement(max_modes), decay_over_omega(max_modes),
      max_modes_(max_modes), requested_(max_modes), inverse_sqrt_mass_(max_modes) {
  const ModeArray none(max_modes);
  for (Level& level : levels_)
    level = {none, none, none, none, none, none, none};
}

void ModalBody::prepare(double sample_rate) noexcept {
  sample_rate_ = within(sample_rate, 1000, 1e7, 48000);
  compute();
}

void ModalBody::set_modes(std::span<const Mode> modes) noexcept {
  count_ = std::min(modes.size(), max_modes_);
  const Mode defaults;
  for (std::size_t i = 0; i < count_; ++i)
    requested_[i] = {modes[i].frequency_hz == 0
                         ? 0
                         : within(modes[i].frequency_hz, 1e-3, 1e7, defaults.frequency_hz),
                     within(modes[i].t60_s, 1e-4, 1e4, defaults.t60_s),
                     within(modes[i].mass_kg, 1e-6, 1e9, defaults.mass_kg)};
  compute();
}

void ModalBody::compute() noexcept {
  for (std::size_t i = 0; i < real.padded(); ++i) {
    const bool sounds = i < count_ && requested_[i].frequency_hz < kMaxRateFraction * sample_rate_;
    const double velocity = real[i] - decay_over_omega[i] * imaginary[i];
    const double old_ratio = // sqrt(omega^2 + d^2)/omega, by which q scales in the energy
        std::sqrt(1 + decay_over_omega[i] * decay_over_omega[i]);
    if (!sounds) {
      real[i] = imaginary[i] = displacement[i] = decay_over_omega[i] = 0;
      if (i < max_modes_)
        inverse_sqrt_mass_[i] = 0;
      for (Level& level : levels_)
        level.pole_real[i] = level.pole_imaginary[i] = level.response_real[i] =
            level.response_imaginary[i] = level.mean_real[i] = level.mean_imaginary[i] =
                level.mobility[i] = 0;
      continue;
    }
    inverse_sqrt_mass_[i] = 1 / std::sqrt(requested_[i].mass_kg);
    const bool rigid = requested_[i].frequency_hz == 0;
    const double decay = rigid ? 0 : kSixtyDecibels / requested_[i].t60_s;
    const double omega = rigid ? kRigidOmega : 2 * std::numbers::pi * requested_[i].frequency_hz;
    displacement[i] = 1 / omega;
    decay_over_omega[i] = decay / omega;
    imaginary[i] *= old_ratio / std::sqrt(1 + decay_over_omega[i] * decay_over_omega[i]);
    real[i] = velocity + decay_over_omega[i] * imaginary[i];
    for (std::size_t l = 0; l < kLevels; ++l) {
      const double h = 1 / (sample_rate_ * static_cast<double>(std::size_t{1} << l));
      const auto [change, response] = step_of({-decay, omega}, h);
      const double per_phase = 1 / (omega * h);
      Level& level = levels_[l];
      level.pole_real[i] = 1 + change.real();
      level.pole_imaginary[i] = change.imag();
      level.response_real[i] = response.real();
      level.response_imaginary[i] = response.imag();
      level.mean_real[i] = change.imag() * per_phase;
      level.mean_imaginary[i] = change.real() * per_phase;
      level.mobility[i] = response.imag() * per_phase;
    }
  }
}

double ModalBody::energy() const noexcept {
  double twice = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double q = imaginary[i], velocity = real[i] - decay_over_omega[i] * q;
    twice += velocity * velocity + (1 + decay_over_omega[i] * decay_over_omega[i]) * q * q;
  }
  return 0.5 * twice;
}

bool ModalBody::flush_denormals() noexcept {
  bool bounded = true;
  for (std::size_t i = 0; i < count_; ++i) {
    const double amplitude = std::abs(real[i]) + std::abs(imaginary[i]);
    if (amplitude < kMinAmplitude)
      real[i] = imaginary[i] = 0;
    bounded = bounded && amplitude < kMaxAmplitude;
  }
  return bounded;
}

void ModalBody::silence() noexcept {
  real.clear();
  imaginary.clear();
}

} // namespace tactus::contact
