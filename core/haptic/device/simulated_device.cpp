#include "core/haptic/device/simulated_device.hpp"

#include <cmath>

namespace tactus::haptic {
namespace {
constexpr double kStop_n_per_m = 2e4;
constexpr double kPeak_n = 40;
// A damper b on a mass M, sampled every T, removes the fraction b T/M of its velocity in each tick.
// The fraction of one fifth at 1 kHz is stable even with a velocity that is estimated a few ticks
// late.
constexpr double kDampingPerMass_hz = 200;
// After a longer gap between two reads only this many ticks are simulated.
constexpr std::uint64_t kMaxCatchUp_ticks = 1000;
using Hold = HandSettings::Hold;
} // namespace

void SimulatedDevice::set(const Settings& settings) noexcept {
  if (settings.seed != settings_.seed)
    random_.seed(settings.seed);
  settings_ = settings;
  if (period_s_ > 0.0)
    prepare(period_s_);
}

void SimulatedDevice::prepare(double period_s) noexcept {
  period_s_ = period_s;
  hand_.set(settings_.hand, period_s);
  const bool held = settings_.hand.hold == Hold::kSpring || settings_.hand.hold == Hold::kPerson;
  const double spring = held ? settings_.hand.stiffness_n_per_m : 0.0;
  const double damper =
      settings_.viscous_n_s_per_m + (held ? settings_.hand.damping_n_s_per_m : 0.0);
  const double mass = settings_.mass_kg;
  stop_damping_ = 2.0 * std::sqrt(kStop_n_per_m * mass);
  free_step_ = MassSpringDamperStep::of(mass, spring, damper, period_s);
  stop_step_ =
      MassSpringDamperStep::of(mass, spring + kStop_n_per_m, damper + stop_damping_, period_s);
}

Caps SimulatedDevice::caps() const noexcept {
  Caps caps;
  caps.peak_force_n = caps.continuous_force_n = kPeak_n;
  caps.damping_limit_n_s_per_m = kDampingPerMass_hz * settings_.mass_kg;
  caps.latency_ticks = settings_.latency_ticks;
  caps.workspace_min = settings_.workspace.min;
  caps.workspace_max = settings_.workspace.max;
  caps.position_noise_m = 0.5 * settings_.resolution_m + settings_.noise_m;
  caps.has_velocity = caps.position_noise_m == 0.0;
  caps.has_buttons = true;
  return caps;
}

bool SimulatedDevice::read(const Tick& tick, State& state) noexcept {
  if (tick.period_s != period_s_)
    prepare(tick.period_s);
  const std::uint64_t elapsed_ticks = started_ && tick.index > index_ ? tick.index - index_ : 0;
  for (auto remaining = std::min(elapsed_ticks, kMaxCatchUp_ticks); remaining > 0; --remaining)
    advance();
  started_ = true;
  index_ = tick.index;

  const PathPoint hand = hand_.point();
  if (settings_.hand.hold == Hold::kRigid) {
    position_ = hand.position;
    velocity_ = hand.velocity;
  }
  State& now = readings_[reads_ % readings_.size()];
  now = {};
  now.position = {measured(position_.x), measured(position_.y), measured(position_.z)};
  now.velocity = velocity_;
  now.buttons = buttons_ | hand.buttons;
  const auto latency =
      static_cast<std::size_t>(std::clamp(settings_.latency_ticks, 0, kMaxLatency_ticks));
  state = readings_[(reads_ - std::min(reads_, latency)) % readings_.size()];
  ++reads_;
  return true;
}

bool SimulatedDevice::write(const Vec3& force_n) noexcept {
  if (!is_finite(force_n))
    return false;
  force_ = force_n;
  return true;
}

void SimulatedDevice::set_button(int button, bool down) noexcept {
  if (button < 0 || button > 31)
    return;
  const std::uint32_t bit = std::uint32_t{1} << button;
  buttons_ = down ? buttons_ | bit : buttons_ & ~bit;
}

void SimulatedDevice::set_state(const Vec3& position, const Vec3& velocity) noexcept {
  position_ = position;
  velocity_ = velocity;
}

void SimulatedDevice::advance() noexcept {
  const PathPoint hand = hand_.point();
  const Hold hold = settings_.hand.hold;
  const bool held = hold == Hold::kSpring || hold == Hold::kPerson;
  for (int axis = 0; axis < 3 && hold != Hold::kRigid; ++axis) {
    double force = force_[axis];
    if (held)
      force += settings_.hand.stiffness_n_per_m * hand.position[axis] +
               settings_.hand.damping_n_s_per_m * hand.velocity[axis];
    const double lowest = settings_.workspace.min[axis] - settings_.stop_m;
    const double highest = settings_.workspace.max[axis] + settings_.stop_m;
    const double edge = std::clamp(position_[axis], lowest, highest);
    const double push = kStop_n_per_m * (edge - position_[axis]) - stop_damping_ * velocity_[axis];
    const bool inward = (edge - position_[axis]) * push > 0.0;
    if (settings_.stops && inward)
      stop_step_.advance(position_[axis], velocity_[axis], force + kStop_n_per_m * edge);
    else
      free_step_.advance(position_[axis], velocity_[axis], force);
  }
  hand_.advance(position_);
}

double SimulatedDevice::measured(double position) noexcept {
  if (settings_.noise_m > 0.0)
    position += settings_.noise_m * (2.0 * random_.uniform() - 1.0);
  const double step = settings_.resolution_m;
  return step > 0.0 ? step * std::floor(position / step + 0.5) : position;
}

} // namespace tactus::haptic
