#include "programs/haptic_check/session.hpp"

#include "programs/haptic_check/terminal.hpp"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <future>
#include <numbers>
#include <thread>

namespace tactus::haptic_check {
namespace {

using Milliseconds = std::chrono::milliseconds;

constexpr double kGraceful_s = 0.3;
constexpr double kMotorsRise_s = 1;
// Number of consecutive readings, 5 ms apart, that must all show a trouble, because a device that
// was not read between two stations needs a moment to answer.
constexpr int kTroubleDebounce = 10;

} // namespace

Vec3 Sines::force(const haptic::Tick& tick, const haptic::State&) noexcept {
  const double time_s = static_cast<double>(tick.index) * tick.period_s;
  for (const Part& part : parts_) {
    if (time_s < part.from_s || time_s >= part.to_s)
      continue;
    const double edge = std::min({time_s - part.from_s, part.to_s - time_s, kFade_s}) / kFade_s;
    const double fade = 0.5 - 0.5 * std::cos(std::numbers::pi * edge);
    const double angle = 2 * std::numbers::pi * part.frequency_hz * (time_s - part.from_s);
    return {part.amplitude_n * fade * std::sin(angle), 0, 0};
  }
  return {};
}

Session::~Session() {
  fade_out();
  servo_.detach();
  device_->close();
}

std::string Session::open() {
  auto opening = std::async(std::launch::async, [this] { return device_->open(); });
  for (int looks = 1; opening.wait_for(Milliseconds(50)) == std::future_status::timeout; ++looks) {
    if (interrupted())
      device_
          ->cancel(); // if a call does not return, the alarm set by the interrupt ends the program
    if (looks % 10 != 0)
      continue;
    std::printf(".");
    std::fflush(stdout);
  }
  return opening.get();
}

/// Sends the servo its heartbeat; without heartbeats its force ends within 150 ms.
void Session::send_heartbeat() noexcept {
  haptic::Command command;
  command.heartbeat_s = devices::ServoThread::now_s();
  servo_.exchange().commands.write(command);
}

void Session::fade_out() noexcept {
  if (!thread_.running())
    return;
  servo_.exchange().motors.pause(true);
  const double give_up_s = devices::ServoThread::now_s() + kGraceful_s;
  while (devices::ServoThread::now_s() < give_up_s) {
    std::this_thread::sleep_for(Milliseconds(1));
    if (servo_.exchange().motors.zero_force_confirmed())
      break;
  }
  static_cast<void>(thread_.stop()); // waits for the thread, since this session owns the servo
}

void Session::drain(Recording& recording) {
  haptic::Report report;
  while (servo_.exchange().trace.pop(report))
    recording.records.push_back({report.tick.index, report.tick.time_s, report.state.position,
                                 report.state.velocity, report.force_n, report.state.buttons,
                                 report.state.flags});
  haptic::SceneEvent event;
  while (scene_.events().pop(event))
    recording.hits += std::holds_alternative<haptic::HitEvent>(event) ? 1 : 0;
  scene_.collect();
}

void Session::record(const Plan& plan, Recording& recording) {
  haptic::Exchange& exchange = servo_.exchange();
  const double start_s = devices::ServoThread::now_s();
  LiveLine line;
  int troubled = 0;
  while (!interrupted()) {
    const double now_s = devices::ServoThread::now_s();
    if (now_s - start_s >= plan.seconds)
      break;
    send_heartbeat();
    drain(recording);
    exchange.reports.read();
    const haptic::Report& report = exchange.reports.latest();
    std::string trouble = device_->trouble();
    troubled = trouble.empty() ? 0 : troubled + 1;
    if (troubled >= kTroubleDebounce)
      recording.trouble = std::move(trouble);
    recording.latched = recording.latched || report.latched;
    if (plan.line)
      line.show(plan.line(report), now_s);
    if (plan.done && plan.done(report))
      break;
    std::this_thread::sleep_for(Milliseconds(5));
  }
  line.end();
}

Recording Session::run(const Plan& plan, std::string& error) {
  Recording recording;
  recording.records.reserve(static_cast<std::size_t>(plan.seconds / plan.period_s) + 1024);
  haptic::ServoSettings settings;
  settings.chain.force_limit_n = plan.force_limit_n;
  settings.chain.enable_s = kMotorsRise_s;
  settings.chain.allowance_w = 0.05; // [phantom]'s default
  const haptic::Caps caps = device_->caps();
  settings.chain.workspace = {caps.workspace_min, caps.workspace_max};
  drain(recording); // discards records of an earlier station
  recording.records.clear();
  recording.hits = 0;
  haptic::Exchange& exchange = servo_.exchange();
  const std::uint64_t lost_before = exchange.trace.dropped();
  scene_.publish(std::make_unique<haptic::Scene>(plan.scene));
  sines_.play(plan.sines);
  exchange.settings.write(settings);
  exchange.motors.pause(false);
  exchange.motors.disable();
  servo_.attach(*device_, &scene_, &sines_);
  if (plan.motors)
    exchange.motors.enable(); // the force rises from zero
  exchange.tracing = true;
  send_heartbeat();
  error = thread_.start(servo_, *device_, plan.period_s);
  if (!error.empty()) {
    exchange.tracing = false;
    return recording;
  }
  record(plan, recording);
  exchange.tracing = false;
  drain(recording);
  recording.scheduling = thread_.scheduling();
  fade_out();
  recording.statistics = servo_.statistics();
  recording.counters = servo_.chain().counters;
  recording.lowest_energy_j = servo_.chain().lowest_energy_j;
  recording.lost = exchange.trace.dropped() - lost_before;
  return recording;
}

} // namespace tactus::haptic_check
