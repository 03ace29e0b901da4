#include "core/contact/modal_body.hpp"

#include "core/contact/elementary.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace tactus::contact {
namespace {

constexpr double kHighest = 0.49;                    // of the sample rate
constexpr double kStill = 1e-20;                     // sqrt(J); a mode below it comes to rest
constexpr double kAbsurd = 1e60;                     // sqrt(J)
constexpr double kSixtyDecibels = 6.907755278982137; // ln 1000

} // namespace

ModalBody::ModalBody(std::size_t most_modes)
    : velocity(most_modes), potential(most_modes), most_(most_modes), wanted_(most_modes),
      per_root_mass_(most_modes) {
  for (Level& level : levels_)
    level = {ModeArray(most_modes), ModeArray(most_modes), ModeArray(most_modes)};
}

void ModalBody::prepare(double sample_rate) noexcept {
  sample_rate_ = within(sample_rate, 1000, 1e7, 48000);
  work_out();
}

void ModalBody::set_modes(std::span<const Mode> modes) noexcept {
  count_ = std::min(modes.size(), most_);
  const Mode usual;
  for (std::size_t i = 0; i < count_; ++i)
    wanted_[i] = {within(modes[i].frequency_hz, 1e-3, 1e7, usual.frequency_hz),
                  within(modes[i].t60_s, 1e-4, 1e4, usual.t60_s),
                  within(modes[i].mass_kg, 1e-6, 1e9, usual.mass_kg)};
  work_out();
}

void ModalBody::work_out() noexcept {
  for (std::size_t i = 0; i < velocity.padded(); ++i) {
    const bool sounds = i < count_ && wanted_[i].frequency_hz < kHighest * sample_rate_;
    if (!sounds) {
      velocity[i] = potential[i] = 0;
      if (i < most_)
        per_root_mass_[i] = 0;
      for (Level& level : levels_)
        level.mean[i] = level.turn[i] = level.displacement[i] = 0;
      continue;
    }
    per_root_mass_[i] = 1 / std::sqrt(wanted_[i].mass_kg);
    const double decay = kSixtyDecibels / wanted_[i].t60_s;
    const double omega = 2 * std::numbers::pi * wanted_[i].frequency_hz;
    for (std::size_t l = 0; l < kLevels; ++l) {
      const double h = 1 / (sample_rate_ * static_cast<double>(std::size_t{1} << l));
      // 1 - 2R cos(omega h) + R^2 and its like without cancellation at small steps.
      const double radius = std::exp(-decay * h), loss = -std::expm1(-decay * h);
      const double sine = std::sin(0.5 * omega * h), cosine = std::cos(0.5 * omega * h);
      const double below = loss * loss + 4 * radius * sine * sine;
      const double above = loss * loss + 4 * radius * cosine * cosine;
      const double square = below / above; // W
      const double damping = (1 + square) * loss * (1 + radius) / (1 + radius * radius);
      levels_[l].mean[i] = 1 / (1 + damping + square);
      levels_[l].turn[i] = std::sqrt(square);
      levels_[l].displacement[i] = 0.5 * h / std::sqrt(square);
    }
  }
}

double ModalBody::energy() const noexcept {
  double twice = 0;
  for (std::size_t i = 0; i < count_; ++i)
    twice += velocity[i] * velocity[i] + potential[i] * potential[i];
  return 0.5 * twice;
}

bool ModalBody::tidy() noexcept {
  bool finite = true; // and of this world
  for (std::size_t i = 0; i < count_; ++i) {
    const double size = std::abs(velocity[i]) + std::abs(potential[i]);
    if (size < kStill)
      velocity[i] = potential[i] = 0;
    finite = finite && size < kAbsurd;
  }
  return finite;
}

void ModalBody::silence() noexcept {
  velocity.clear();
  potential.clear();
}

} // namespace tactus::contact
