#include "core/contact/modal_body.hpp"

#include "core/contact/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>

namespace tactus::contact {
namespace {

constexpr double kHighest = 0.49; // of the sample rate
constexpr double kStill = 1e-20;  // sqrt(J); a mode below it comes to rest
constexpr double kAbsurd = 1e60;  // sqrt(J)
/// 1/s of a rigid motion: after a second its speed has changed by less than 1e-16 of itself.
constexpr double kRigid = 1e-8;
constexpr double kSixtyDecibels = 6.907755278982137; // ln 1000

/// B = (e^(s h) - 1)/s, and P - 1.
struct Step {
  std::complex<double> change, response;
};
Step step_of(std::complex<double> rate, double h) noexcept {
  const std::complex<double> x = rate * h;
  if (std::abs(x) < 0.1) { // the difference from its series: sum of x^n/(n + 1)!
    std::complex<double> sum = 0;
    for (int n = 10; n >= 0; --n)
      sum = 1.0 + x / static_cast<double>(n + 2) * sum;
    return {x * sum, h * sum};
  }
  const double radius = std::exp(x.real()), sine = std::sin(0.5 * x.imag());
  const std::complex<double> change{std::expm1(x.real()) - 2 * radius * sine * sine,
                                    radius * std::sin(x.imag())};
  return {change, change / rate};
}

} // namespace

ModalBody::ModalBody(std::size_t max_modes)
    : real(max_modes), imaginary(max_modes), displacement(max_modes), slowing(max_modes),
      max_modes_(max_modes), wanted_(max_modes), per_root_mass_(max_modes) {
  const ModeArray none(max_modes);
  for (Level& level : levels_)
    level = {none, none, none, none, none, none, none};
}

void ModalBody::prepare(double sample_rate) noexcept {
  sample_rate_ = within(sample_rate, 1000, 1e7, 48000);
  work_out();
}

void ModalBody::set_modes(std::span<const Mode> modes) noexcept {
  count_ = std::min(modes.size(), max_modes_);
  const Mode usual;
  for (std::size_t i = 0; i < count_; ++i)
    wanted_[i] = {modes[i].frequency_hz == 0
                      ? 0
                      : within(modes[i].frequency_hz, 1e-3, 1e7, usual.frequency_hz),
                  within(modes[i].t60_s, 1e-4, 1e4, usual.t60_s),
                  within(modes[i].mass_kg, 1e-6, 1e9, usual.mass_kg)};
  work_out();
}

void ModalBody::work_out() noexcept {
  for (std::size_t i = 0; i < real.padded(); ++i) {
    const bool sounds = i < count_ && wanted_[i].frequency_hz < kHighest * sample_rate_;
    const double velocity = real[i] - slowing[i] * imaginary[i];
    const double stretch = std::sqrt(1 + slowing[i] * slowing[i]); // of omega^2 + d^2 over omega^2
    if (!sounds) {
      real[i] = imaginary[i] = displacement[i] = slowing[i] = 0;
      if (i < max_modes_)
        per_root_mass_[i] = 0;
      for (Level& level : levels_)
        level.turn_real[i] = level.turn_imaginary[i] = level.response_real[i] =
            level.response_imaginary[i] = level.mean_real[i] = level.mean_imaginary[i] =
                level.mobility[i] = 0;
      continue;
    }
    per_root_mass_[i] = 1 / std::sqrt(wanted_[i].mass_kg);
    const bool rigid = wanted_[i].frequency_hz == 0;
    const double decay = rigid ? 0 : kSixtyDecibels / wanted_[i].t60_s;
    const double omega = rigid ? kRigid : 2 * std::numbers::pi * wanted_[i].frequency_hz;
    displacement[i] = 1 / omega;
    slowing[i] = decay / omega;
    imaginary[i] *= stretch / std::sqrt(1 + slowing[i] * slowing[i]);
    real[i] = velocity + slowing[i] * imaginary[i];
    for (std::size_t l = 0; l < kLevels; ++l) {
      const double h = 1 / (sample_rate_ * static_cast<double>(std::size_t{1} << l));
      const auto [change, response] = step_of({-decay, omega}, h);
      const double per_way = 1 / (omega * h);
      Level& level = levels_[l];
      level.turn_real[i] = 1 + change.real();
      level.turn_imaginary[i] = change.imag();
      level.response_real[i] = response.real();
      level.response_imaginary[i] = response.imag();
      level.mean_real[i] = change.imag() * per_way;
      level.mean_imaginary[i] = change.real() * per_way;
      level.mobility[i] = response.imag() * per_way;
    }
  }
}

double ModalBody::energy() const noexcept {
  double twice = 0;
  for (std::size_t i = 0; i < count_; ++i) {
    const double q = imaginary[i], velocity = real[i] - slowing[i] * q;
    twice += velocity * velocity + (1 + slowing[i] * slowing[i]) * q * q;
  }
  return 0.5 * twice;
}

bool ModalBody::tidy() noexcept {
  bool finite = true; // and of this world
  for (std::size_t i = 0; i < count_; ++i) {
    const double size = std::abs(real[i]) + std::abs(imaginary[i]);
    if (size < kStill)
      real[i] = imaginary[i] = 0;
    finite = finite && size < kAbsurd;
  }
  return finite;
}

void ModalBody::silence() noexcept {
  real.clear();
  imaginary.clear();
}

} // namespace tactus::contact
