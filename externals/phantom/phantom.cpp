#include "externals/phantom/phantom.hpp"

#include "core/words.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <thread>

namespace tactus {
namespace {

// Two grids that meet at one instant differ by the rounding of their times only.
constexpr double kSameInstant_ms = 1e-6;
// A wall-clock servo is fed at least this often with signs of life.
constexpr double kHeartbeat_ms = 5;
// Time always goes on between two wake-ups, whatever happens in between.
constexpr double kShortestWake_ms = 1e-3;
constexpr double kGraceful_s = 0.2;

enum Tag : std::size_t { kMm, kVel, kForce, kButtonTag, kStatus, kJitter, kError };

} // namespace

using namespace phantom;
using haptic::Action;

Phantom::Phantom() {
  for (std::size_t i = 0; i < kParameters.size(); ++i)
    values_[i] = kParameters[i].initial;
  settle();
  settle_device();
}

Phantom::~Phantom() { fade_out(); }

/// Ends a servo thread with the force down by its slew, or after 200 ms whatever it does.
void Phantom::fade_out() noexcept {
  if (!runner_.running())
    return;
  servo_.exchange().actions.push(Action::kMotorsOff);
  const double give_up_s = devices::ServoThread::now_s() + kGraceful_s;
  while (devices::ServoThread::now_s() < give_up_s) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
    servo_.exchange().reports.read();
    const haptic::Report& report = servo_.exchange().reports.latest();
    if (!report.motors && norm(report.force_n) == 0.0)
      break;
  }
  runner_.stop();
}

void Phantom::set(std::size_t parameter, double value) noexcept {
  values_[parameter] = value;
  if (parameter == kMotors)
    servo_.exchange().actions.push(on(kMotors) ? Action::kMotorsOn : Action::kMotorsOff);
  if (parameter == kRate || parameter == kOutRate)
    new_grids_ = true;
  if (parameter == kRate || parameter >= kMass)
    settle_device();
  else
    settle();
}

/// Carries the chain's parameters to the servo.
void Phantom::settle() noexcept {
  auto& chain = settings_.chain;
  chain.force_limit_n = values_[kForceMax];
  const double peak_n = simulated_.caps().peak_force_n;
  if (peak_n > 0)
    chain.force_limit_n = std::min(chain.force_limit_n, peak_n);
  chain.slew_n_per_s = values_[kSlew] * 1e3;
  chain.extrapolation_s = values_[kExtrap] * 1e-3;
  chain.strict = on(kStrict);
  chain.passivity = on(kPassivity);
  chain.tank_j = values_[kTank];
  chain.allowance_w = values_[kAllowance];
  chain.damping_n_s_per_m = values_[kDamp];
  chain.wall_n_per_m = values_[kWalls];
  servo_.exchange().settings.write(settings_);
}

/// Carries the simulated device's parameters to it, and a new rate to whoever steps it.
void Phantom::settle_device() noexcept {
  simulation_.mass_kg = values_[kMass];
  simulation_.viscous_n_s_per_m = values_[kViscous];
  simulation_.stops = on(kStops);
  simulation_.resolution_m = values_[kResolution] * 1e-3;
  simulation_.noise_m = values_[kNoise] * 1e-3;
  simulation_.seed = simulation_.hand.seed = static_cast<std::uint64_t>(values_[kSeed]);
  with_device([this] {
    const double before = simulated_.caps().position_noise_m;
    simulated_.set(simulation_);
    if (simulated_.caps().position_noise_m != before)
      servo_.refresh_caps();
  });
}

void Phantom::created(Host& host) {
  created_ = true;
  open(host);
}

void Phantom::open(Host& host) {
  if (open_)
    return close(host), open(host);
  if (const std::string refusal = simulated_.open(); !refusal.empty())
    return host.error(refusal);
  open_ = true;
  servo_.attach(simulated_);
  if (!on(kMotors))
    servo_.exchange().actions.push(Action::kMotorsOff);
  begin(host);
  if (reported_[kStatus])
    host.info({"status", "open", "sim"});
}

void Phantom::close(Host& host) {
  if (!open_)
    return;
  open_ = false;
  fade_out();
  servo_.detach();
  static_cast<void>(simulated_.write({}));
  simulated_.close();
  if (reported_[kStatus])
    host.info({"status", "closed", "sim"});
}

/// A fresh grid of servo ticks and one of outputs, both from now on.
void Phantom::begin(Host& host) {
  origin_ms_ = output_origin_ms_ = host.now_ms();
  steps_ = outputs_ = 0;
  scheduling_told_ = false;
  if (open_ && wall_) {
    publish(devices::ServoThread::now_s());
    runner_.start(servo_, period_s());
  }
  host.wake_in(kSchedule, 0);
}

void Phantom::restart(Host& host) {
  if (!created_ || !open_)
    return;
  fade_out();
  servo_.attach(simulated_);
  if (!on(kMotors))
    servo_.exchange().actions.push(Action::kMotorsOff);
  begin(host);
}

void Phantom::scalar(std::size_t inlet, double value, Host& host) {
  if (std::isfinite(value)) {
    asked_[static_cast<int>(inlet)] = value;
    changed_now_ = true;
  } else {
    refused_now_ = true;
  }
  host.wake_in(kForces, 0);
}

void Phantom::publish(double now_s) noexcept {
  command_.heartbeat_s = now_s;
  servo_.exchange().commands.write(command_);
}

void Phantom::tick(std::size_t timer, Host& host) {
  if (timer == kForces) {
    if (refused_now_) {
      ++command_.refused;
      command_.last_refused = true;
      if (host.now_ms() - last_error_ms_ >= 1000) {
        last_error_ms_ = host.now_ms();
        host.error("force: not a finite number; the last good force stays for the watchdog's time");
        if (reported_[kError])
          host.info({"error", "nan", "force", "refused"});
      }
    } else if (changed_now_) {
      const double unit_n = on(kUnitsParameter) ? settings_.chain.force_limit_n : 1.0;
      command_.force_n = asked_ * unit_n;
      ++command_.number;
      command_.last_refused = false;
    }
    refused_now_ = changed_now_ = false;
    return publish(wall_ ? devices::ServoThread::now_s() : host.now_ms() * 1e-3);
  }
  if (new_grids_) {
    new_grids_ = false;
    origin_ms_ = output_origin_ms_ = host.now_ms();
    steps_ = outputs_ = 0;
  }
  if (!open_)
    return;
  const double now = host.now_ms() + kSameInstant_ms;
  const double period_ms = 1e3 * period_s();
  if (!wall_) {
    // One tick at most: a host that jumps forward gets no burst.
    if (origin_ms_ + static_cast<double>(steps_) * period_ms <= now) {
      step(host);
      ++steps_;
    }
  } else {
    publish(devices::ServoThread::now_s());
  }
  const double rate = values_[kOutRate];
  collect(host);
  if (rate > 0 && output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate <= now) {
    ++outputs_;
    send_values(host, false);
    send_position(host, on(kRepeat));
  }
  schedule(host);
}

void Phantom::schedule(Host& host) {
  if (!open_)
    return; // opening starts the grids anew
  const double now = host.now_ms(), rate = values_[kOutRate], period_ms = 1e3 * period_s();
  double next = now + kHeartbeat_ms;
  if (!wall_) {
    // After a jump of the host, or another rate, the grid starts anew where it would be late.
    if (origin_ms_ + static_cast<double>(steps_) * period_ms < now - kSameInstant_ms) {
      origin_ms_ = now;
      steps_ = 1;
    }
    next = std::min(next, origin_ms_ + static_cast<double>(steps_) * period_ms);
  }
  if (rate > 0) {
    if (output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate < now - kSameInstant_ms) {
      output_origin_ms_ = now;
      outputs_ = 1;
    }
    next = std::min(next, output_origin_ms_ + static_cast<double>(outputs_) * 1e3 / rate);
  }
  host.wake_in(kSchedule, std::max(kShortestWake_ms, next - now));
}

void Phantom::step(Host& host) {
  const double now_s = host.now_ms() * 1e-3;
  publish(now_s);
  servo_.step({index_++, now_s, period_s()});
}

/// Takes over what the servo has to tell.
void Phantom::collect(Host& host) {
  has_report_ = servo_.exchange().reports.read() || has_report_;
  drain_trace();
  if (learning_ && has_report_) {
    const auto before = settings_.chain.workspace;
    settings_.chain.workspace.include(servo_.exchange().reports.latest().state.position);
    if (!(before == settings_.chain.workspace))
      servo_.exchange().settings.write(settings_);
  }
  haptic::Event event;
  for (int taken = 0; taken < 256 && servo_.exchange().events.pop(event); ++taken)
    send_event(event, host);
  if (!wall_)
    return;
  if (!scheduling_told_ && !runner_.scheduling().empty()) {
    scheduling_told_ = true;
    if (reported_[kStatus])
      host.info({"status", "sched", runner_.scheduling()});
  }
  if (reported_[kJitter] && host.now_ms() - last_timing_ms_ >= 1000)
    send_timing(host);
}

void Phantom::drain_trace() {
  haptic::Report report;
  for (int taken = 0; taken < 1024 && servo_.exchange().trace.pop(report); ++taken)
    trace_.write(report);
}

void Phantom::send_event(const haptic::Event& event, Host& host) {
  using Kind = haptic::Event::Kind;
  switch (event.kind) {
  case Kind::kButton:
    if (reported_[kButtonTag])
      host.info({"button", static_cast<double>(event.number), event.on ? 1.0 : 0.0});
    break;
  case Kind::kWatchdog:
    if (reported_[kStatus])
      host.info({"status", "watchdog", event.on ? 1.0 : 0.0});
    break;
  case Kind::kFault:
    host.error("the device has failed and its motors are off; check it, then send motors 1");
    if (reported_[kStatus])
      host.info({"status", "fault", 1.0});
    break;
  }
}

void Phantom::send_position(Host& host, bool always) {
  if (!has_report_)
    return;
  const auto position =
      settings_.chain.workspace.normalised(servo_.exchange().reports.latest().state.position);
  if (!always && sent_ && *sent_ == position)
    return;
  sent_ = position;
  host.send(2, {position.z});
  host.send(1, {position.y});
  host.send(0, {position.x});
}

void Phantom::send_values(Host& host, bool all) {
  if (!has_report_)
    return;
  const haptic::Report report = servo_.exchange().reports.latest();
  const auto triple = [&host](std::string_view tag, const haptic::Vec3& v) {
    host.info({tag, v.x, v.y, v.z});
  };
  if (all || reported_[kMm])
    triple("mm", report.state.position * 1e3);
  if (all || reported_[kVel])
    triple("vel", report.state.velocity);
  if (all || reported_[kForce])
    triple("force", report.force_n);
}

haptic::ServoStatistics Phantom::statistics() noexcept {
  if (!runner_.running())
    return servo_.statistics();
  servo_.exchange().statistics.read();
  return servo_.exchange().statistics.latest();
}

void Phantom::send_timing(Host& host) {
  last_timing_ms_ = host.now_ms();
  const auto s = statistics();
  host.info({"jitter", s.lateness.mean_s() * 1e3, s.lateness.quantile_s(0.5) * 1e3,
             s.lateness.quantile_s(0.95) * 1e3, s.lateness.quantile_s(0.99) * 1e3,
             s.lateness.longest_s() * 1e3});
}

void Phantom::message(std::size_t index, Words arguments, Host& host) {
  switch (index) {
  case kBang:
    collect(host);
    send_values(host, true);
    return send_position(host, true);
  case kList:
    return on_list(arguments, host);
  case kBackend:
    return on_backend(arguments, host);
  case kOpen:
    return open(host);
  case kClose:
    return close(host);
  case kName:
    name_ =
        arguments[0].is_word ? std::string(arguments[0].word) : number_text(arguments[0].number);
    return;
  case kDevices:
    return host.info({"device", "sim", 0.0, "tactus", "simulated", std::string_view(name_),
                      open_ ? "open" : "closed"});
  case kClock:
    return on_clock(arguments, host);
  case kWorkspace:
    return on_workspace(arguments, host);
  case kMap:
    return on_map(arguments, host);
  case kInterp:
    return on_interp(arguments, host);
  case kWatchdog:
    return on_watchdog(arguments, host);
  case kEstop:
    servo_.exchange().actions.push(Action::kEmergencyStop);
    if (reported_[kStatus])
      host.info({"status", "estop", 1.0});
    return;
  case kReport:
    return on_report(arguments, host);
  case kStats:
    return on_stats(arguments, host);
  case kTrace:
    return on_trace(arguments, host);
  case kHand:
    return on_hand(arguments, host);
  case kPath:
    return on_path(arguments, host);
  case kTarget:
    return on_target(arguments, host);
  case kSeek:
    return on_seek(arguments, host);
  case kButton:
    return on_button(arguments, host);
  default:
    return;
  }
}

} // namespace tactus
