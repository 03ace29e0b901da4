#include "externals/phantom/estop_latches.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"

#include <string>

/// [phantom]'s settings, motors and emergency stop.
namespace tactus {

using namespace phantom;

void Phantom::rate_changed() {
  restart_grids();
  if (running_ && !device_->owns_thread())
    session_.thread()->set_period(period_s());
  apply_simulation();
  if (open())
    configure_signals();
}

/// Sends the chain's settings to the servo.
void Phantom::apply_settings() noexcept {
  exchange().settings.write(setup_.update(device().caps(), !driver_));
  session_.rig().signals->set_workspace(setup_.settings.chain.workspace);
}

/// Sets the simulated device; restarts the thread that steps it, with the present rate.
void Phantom::apply_simulation() noexcept {
  simulation_.apply([this] {
    if (!driver_)
      session_.rig().servo.refresh_caps();
  });
  if (!driver_)
    update_limits();
}

/// Sends the device's limits to the models in the servo.
void Phantom::update_limits() noexcept {
  session_.rig().scene.set_continuous_force(device().caps().continuous_force_n);
  session_.rig().effects.set_damping_limit(device().caps().damping_limit_n_s_per_m);
}

/// What the device renders stably: the stiffness that it states, or else Colgate's bound of a
/// sampled spring, K < 2 (B + b)/T. None for a device without motors, and for a real device before
/// it is open, since its capabilities are not known.
FeltModels::Limits Phantom::stability_limits() const noexcept {
  if (driver_ && !(open() && device_->caps().axes_out > 0))
    return {};
  const haptic::Caps caps = device().caps();
  const double own = caps.stiffness_limit_n_per_m;
  const double viscous = driver_ ? 0.0 : simulation_.given.viscous_n_s_per_m;
  const double damping = setup_.given.damp_n_s_per_m;
  return StabilityLimits{
      own > 0 ? own : 2 * (damping + viscous) / period_s(),
      haptic::EffectModel::max_passive_damping(caps.damping_limit_n_s_per_m, period_s())};
}

void Phantom::set_clock(Words words, Host& host) {
  if (is(words[0], "logical") && driver_ && link_ != Link::kClosed)
    return host.error("clock logical: a real device cannot be stepped by the patch's time");
  if (is(words[0], "auto"))
    clock_ = Clock::kAuto;
  else if (is(words[0], "logical"))
    clock_ = Clock::kLogical;
  else if (is(words[0], "wall"))
    clock_ = Clock::kWall;
  else
    return host.error(expected("clock", words[0], "auto, logical or wall"));
  if (driver_)
    return; // a real device always runs on the wall clock
  wall_ = clock_ == Clock::kWall;
  restart(host);
}

void Phantom::set_workspace(Words words, Host& host) {
  const Vec3* const position = output_.has_report() ? &report().state.position : nullptr;
  if (const std::string refusal = setup_.set_workspace(words, device().caps(), position, host);
      !refusal.empty())
    return host.error(refusal);
  apply_settings();
}

void Phantom::play_network(Words words, Host& host) {
  say(models_.network(words, session_.rig(), period_s(), stability_limits(), host), host);
}

bool Phantom::for_simulation(std::string_view message, Host& host) const {
  if (!driver_)
    return true;
  host.error(std::string(message) + ": only for the simulated device, not for " +
             std::string(driver_name()) + "; send backend sim first");
  return false;
}

void Phantom::set_hand(const Message& row, Words words, Host& host) {
  if (!for_simulation(row.name, host))
    return;
  if (const std::string refusal = simulation_.hold(words); !refusal.empty())
    return host.error(refusal);
  apply_simulation();
}

void Phantom::set_motors(bool on) noexcept {
  motors_ = on;
  if (!on) {
    exchange().motors.disable();
  } else {
    exchange().motors.enable();
    stop_.release();
  }
}

/// Switches the motors off until `motors 1`; the parameter then reads 0.
void Phantom::switch_off() noexcept {
  motors_ = false;
  exchange().motors.disable();
}

void Phantom::stop(Host& host) {
  exchange().motors.emergency_stop();
  latch_stop();
  stop_.report(exchange().motors, reports_, host, true);
}

/// Latches the stop for this name and this device.
void Phantom::latch_stop() noexcept {
  motors_ = false;
  if (audio_.name() != "-")
    stop_.latch(name_key(audio_.name()));
  if (driver_ && (open() || link_ == Link::kLost))
    stop_.latch(device_key_);
}

/// Applies the stop that an earlier object latched for this name or device.
void Phantom::inherit_stop(const std::string& key, Host& host) {
  if (!stop_.inherit(key, exchange().motors, host))
    return;
  motors_ = false;
  stop_.report(exchange().motors, reports_, host);
}

void Phantom::dump(Host& host) {
  host.info({"backend", driver_name()});
  host.info({"name", std::string_view(audio_.name())});
  host.info({"clock", wall_ ? "wall" : "logical"});
  host.info({"estop", exchange().motors.request().stopped ? 1.0 : 0.0});
  setup_.dump(host);
  models_.dump(period_s(), host);
  if (!driver_)
    simulation_.dump(host);
}

} // namespace tactus
