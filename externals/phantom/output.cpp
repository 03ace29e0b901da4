#include "core/declaration_text.hpp"
#include "core/message_time.hpp"
#include "externals/phantom/numbers.hpp"
#include "externals/phantom/phantom.hpp"
#include "externals/phantom/tags.hpp"

#include <algorithm>
#include <cmath>

/// [phantom]'s output: positions, events, statistics and trace.
namespace tactus {

using namespace phantom;

namespace {

constexpr double kMaxHostStall_s = 0.1; // between calls of collect(), normally every 5 ms

} // namespace

/// Reads the servo's reports and events, and sends the events.
void Phantom::collect(Host& host) {
  const double now_s = devices::ServoThread::now_s();
  const bool stalled =
      now_s - collected_s_ > kMaxHostStall_s; // then the servo may have stalled, too
  if (wall_)
    clock_map_.follow(host.now_ms(), now_s);
  collected_s_ = now_s;
  const bool is_new = exchange().reports.read();
  has_report_ = has_report_ || is_new;
  if (is_new || stalled)
    report_s_ = now_s;
  drain_trace();
  if (learning_ && has_report_) {
    const auto before = settings_.chain.workspace;
    settings_.chain.workspace.include(exchange().reports.latest().state.position);
    if (!(before == settings_.chain.workspace)) {
      exchange().settings.write(settings_);
      rig_->signals->set_workspace(settings_.chain.workspace);
    }
  }
  const auto send_all = [&](auto& events, auto event) {
    for (int taken = 0; taken < 256 && events.pop(event); ++taken)
      std::visit([&](const auto& one) { send(one, host); }, event);
  };
  send_all(exchange().events, haptic::ServoEvent());
  send_all(rig_->scene.events(), haptic::SceneEvent());
  rig_->scene.collect();
  rig_->network.collect();
  watch_queues(host);
  send_estop(host);
  watch_chain(host);
  if (driver_)
    watch_device(host);
  if (!wall_ || !open() || (driver_ && !running_))
    return;
  if (!scheduling_reported_ && !runner_->scheduling().empty()) {
    scheduling_reported_ = true;
    if (reported_[kStatus])
      host.info({"status", "sched", runner_->scheduling()});
  }
  if (reported_[kJitter] && host.now_ms() - last_timing_ms_ >= 1000)
    send_timing(host);
}

/// Converts a time of the servo's clock to the patch's logical time, ms.
double Phantom::patch_ms(double servo_s) const noexcept {
  return wall_ ? clock_map_.host_ms(servo_s) : servo_s * 1e3;
}

void Phantom::drain_trace() {
  haptic::Report report;
  for (int taken = 0; taken < 1024 && exchange().trace.pop(report); ++taken)
    trace_.write(report, patch_ms(report.tick.time_s));
}

/// Reports entries that full queues have dropped, once a second.
void Phantom::watch_queues(Host& host) {
  const std::uint64_t lost =
      exchange().events.dropped() + rig_->scene.events().dropped() + exchange().trace.dropped();
  if (lost == lost_reported_ || host.now_ms() - last_loss_ms_ < 1000)
    return;
  last_loss_ms_ = host.now_ms();
  host.error("events: " + number_text(static_cast<double>(lost - lost_reported_)) +
             " events or trace rows were lost: the patch did not read them in time");
  lost_reported_ = lost;
}

void Phantom::send(const haptic::ButtonEvent& event, Host& host) {
  if (reported_[kButtonTag])
    host.info({"button", static_cast<double>(event.number), event.on ? 1.0 : 0.0});
}

void Phantom::send(const haptic::WatchdogEvent& event, Host& host) {
  if (reported_[kStatus])
    host.info({"status", "watchdog", event.on ? 1.0 : 0.0});
}

void Phantom::send(const haptic::HitEvent& event, Host& host) {
  const Vec3 p = event.point * 1e3, &n = event.normal;
  if (reported_[kHitTag])
    host.info({"hit", message_time(patch_ms(event.time_s)), scene_.name_of(event.key), p.x, p.y,
               p.z, n.x, n.y, n.z, event.approach_m_per_s, event.slip_m_per_s});
}

void Phantom::send(const haptic::ContactEvent& event, Host& host) {
  const Vec3& f = event.force_n;
  if (reported_[kContactTag])
    host.info({"contact", message_time(patch_ms(event.time_s)), scene_.name_of(event.key),
               event.depth_m * 1e3, f.x, f.y, f.z});
}

void Phantom::send(const haptic::ReleaseEvent& event, Host& host) {
  if (reported_[kReleaseTag])
    host.info({"release", message_time(patch_ms(event.time_s)), scene_.name_of(event.key)});
}

void Phantom::send_position(Host& host, bool always) {
  if (!has_report_)
    return;
  const auto position =
      settings_.chain.workspace.normalised(exchange().reports.latest().state.position);
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
  const haptic::Report report = exchange().reports.latest();
  const auto send_vector = [&host](std::string_view tag, const Vec3& v) {
    host.info({tag, v.x, v.y, v.z});
  };
  if (all || reported_[kMm])
    send_vector("mm", report.state.position * 1e3);
  if (all || reported_[kVel])
    send_vector("vel", report.state.velocity);
  if (all || reported_[kForce])
    send_vector("force", report.force_n);
  if (reported_[kRot] || (all && device().caps().has_rotation))
    send_vector("rot", report.state.rotation);
  send_wrist(host, all);
}

void Phantom::send_workspace(Host& host) const {
  const Vec3 low = settings_.chain.workspace.min * 1e3, high = settings_.chain.workspace.max * 1e3;
  host.info({"workspace", low.x, low.y, low.z, high.x, high.y, high.z});
}

haptic::ServoStatistics Phantom::statistics() noexcept {
  if (!driver_ && !runner_->running())
    return rig_->servo.statistics();
  exchange().statistics.read();
  return exchange().statistics.latest();
}

void Phantom::send_timing(Host& host) {
  last_timing_ms_ = host.now_ms();
  const auto s = statistics();
  host.info({"jitter", s.lateness.mean_s() * 1e3, s.lateness.quantile_s(0.5) * 1e3,
             s.lateness.quantile_s(0.95) * 1e3, s.lateness.quantile_s(0.99) * 1e3,
             s.lateness.max_s() * 1e3});
}

void Phantom::on_report(Words words, Host& host) {
  for (std::size_t i = 0; i < kTags.size(); ++i)
    if (is(words[0], kTags[i])) {
      if (words[1].is_word)
        return host.error(expected("report", words[1], "0 or 1"));
      reported_[i] = words[1].number != 0;
      return;
    }
  host.error(
      expected("report", words[0],
               "mm, vel, force, button, status, jitter, error, hit, contact, release, rot, torque "
               "or grip"));
}

void Phantom::on_stats(Words words, Host& host) {
  if (!words.empty() && !is(words[0], "reset"))
    return host.error(expected("stats", words[0], "reset"));
  if (!words.empty()) {
    ++exchange().statistics_resets;
    return;
  }
  collect(host);
  const haptic::ServoStatistics s = statistics();
  const haptic::Report& r = exchange().reports.latest();
  const auto line = [&host](std::string_view name, double value) {
    host.info({"stats", name, value});
  };
  const auto count = [&line](std::string_view name, std::uint64_t value) {
    line(name, static_cast<double>(value));
  };
  count("ticks", s.ticks);
  count("overruns", s.overruns);
  count("skipped", s.skipped);
  line("late_mean_ms", s.lateness.mean_s() * 1e3);
  line("late_p50_ms", s.lateness.quantile_s(0.5) * 1e3);
  line("late_p99_ms", s.lateness.quantile_s(0.99) * 1e3);
  line("late_max_ms", s.lateness.max_s() * 1e3);
  line("work_mean_ms", s.work.mean_s() * 1e3);
  line("work_max_ms", s.work.max_s() * 1e3);
  count("device_errors", s.device_errors);
  count("watchdog_trips", r.counters.watchdog_trips);
  count("clamped", r.counters.clamped);
  count("slewed", r.counters.slewed);
  count("braked", r.counters.braked);
  count("refused", r.counters.refused);
  count("events_lost", exchange().events.dropped() + rig_->scene.events().dropped());
  count("trace_lost", exchange().trace.dropped());
  line("clock_drift_ppm", clock_map_.drift_ppm());
  count("clock_leaps", clock_map_.leaps());
  line("energy_j", r.energy_j);
  line("lowest_energy_j", r.lowest_energy_j);
}

void Phantom::on_trace(Words words, Host& host) {
  if (!words[0].is_word)
    return host.error(expected("trace", words[0], "a file name or stop"));
  drain_trace();
  exchange().tracing = false;
  const std::string rest = trace_.close();
  if (!rest.empty())
    host.error("trace: " + rest);
  if (is(words[0], "stop"))
    return;
  const std::string path = host.new_file(words[0].word);
  const std::string refusal = trace_.open(path);
  if (!refusal.empty())
    return host.error("trace " + std::string(words[0].word) + ": cannot be written: " + refusal);
  exchange().tracing = true;
}

} // namespace tactus
