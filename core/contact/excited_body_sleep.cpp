#include "core/contact/excited_body.hpp"

#include <algorithm>
#include <cmath>

/// Exciters that cannot reach the surface for a while sleep: step() does not check them. An island
/// sleeps as a whole, so that its modes only decay meanwhile.
namespace tactus::contact {
namespace {

constexpr double kMargin = 3; // samples: kLookAhead and one more

} // namespace

/// True if the exciter cannot touch within this many samples while nothing else moves its modes.
/// Under this condition |z| of a mode does not grow. So the mode's displacement changes by at most
/// |z| times the smaller of 2/omega and time sqrt(1 + (d/omega)^2).
bool ExcitedBody::cannot_reach(std::size_t slot, double samples) const noexcept {
  const Exciter& e = exciters_[slot];
  if (e.kind == Exciter::Kind::kFriction)
    return !(e.normal_force_n > 0);
  if (e.impact.touching())
    return false;
  const double time = (samples + kMargin) * step_s_[0];
  const double acceleration = e.external_force_n * e.inverse_mass;
  const double fastest = std::abs(e.velocity_m_per_s) + time * std::abs(acceleration);
  if (!(fastest < kMaxSpeed) || !(std::abs(e.position_m) + time * fastest < kMaxDistance))
    return false;
  double travel = 0, speed = std::max(e.velocity_m_per_s + time * std::max(acceleration, 0.0), 0.0);
  travel = time * speed;
  for (const std::uint32_t i : point_modes_[slot]) {
    const double amplitude =
        std::abs(point_shape_[slot][i]) * (std::abs(body_.real[i]) + std::abs(body_.imaginary[i]));
    const double rate = std::sqrt(1 + body_.decay_over_omega[i] * body_.decay_over_omega[i]);
    travel += amplitude * std::min(2 * body_.displacement[i], time * rate);
    speed += amplitude * rate;
  }
  return e.position_m - surface(slot) + travel + kMargin * step_s_[0] * speed < 0;
}

/// Moves a sleeping mass to the present, with constant acceleration.
void ExcitedBody::catch_up(std::size_t slot) const noexcept {
  Exciter& e = exciters_[slot];
  const Sleep& from = sleep_[slot];
  const double time = static_cast<double>(clock_ - from.since) * step_s_[0];
  const double velocity_change = time * e.external_force_n * e.inverse_mass;
  e.velocity_m_per_s = from.velocity_m_per_s + velocity_change;
  e.position_m = from.position_m + time * (from.velocity_m_per_s + 0.5 * velocity_change);
}

void ExcitedBody::update_sleep() noexcept {
  for (std::size_t k = 0; k < in_use_.size(); ++k) {
    if (sleep_until_[k] > clock_)
      continue;
    const std::span<const std::size_t> slots = in_use_.slots(k);
    const auto none_can_reach = [&](double samples) {
      return std::all_of(slots.begin(), slots.end(),
                         [&](std::size_t i) { return cannot_reach(i, samples); });
    };
    for (const std::size_t i : slots)
      if (sleep_[i].sleeps)
        catch_up(i);
    std::uint64_t samples = 64 * kFlushPeriod;
    while (samples >= kFlushPeriod && !none_can_reach(static_cast<double>(samples)))
      samples /= 8;
    const bool sleeps = samples >= kFlushPeriod;
    sleep_until_[k] = sleeps ? clock_ + samples : 0;
    for (const std::size_t i : slots) {
      Exciter& e = exciters_[i];
      awake_changed_ = awake_changed_ || sleeps != sleep_[i].sleeps;
      if (sleeps && !sleep_[i].sleeps) {
        sleep_[i] = {true, clock_, e.position_m, e.velocity_m_per_s};
        e.friction.release();
        e.last_force_n = e.force_n = e.impulse_ns = e.dissipated_j = 0;
        e.near = e.depth_valid = false;
      }
      sleep_[i].sleeps = sleeps;
    }
  }
}

/// Wakes an exciter and all exciters that may share a mode with it.
void ExcitedBody::wake_island(std::size_t slot) noexcept {
  const std::size_t k = island_of_[slot];
  sleep_until_[k] = 0;
  awake_changed_ = true;
  for (const std::size_t i : in_use_.slots(k)) {
    catch_up(i);
    sleep_[i].sleeps = false;
  }
}

/// Wakes all exciters that a force at this contact point may affect.
void ExcitedBody::wake_around(std::size_t slot) noexcept {
  if (exciters_[slot].kind != Exciter::Kind::kNone && !order_stale_)
    wake(slot);
  else
    wake_all();
}

void ExcitedBody::wake_all() noexcept {
  for (std::size_t i = 0; i < sleep_.size(); ++i)
    wake(i);
}

} // namespace tactus::contact
