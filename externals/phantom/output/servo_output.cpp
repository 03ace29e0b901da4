#include "externals/phantom/output/servo_output.hpp"

#include "core/declaration_text.hpp"
#include "core/message_time.hpp"
#include "devices/servo_thread.hpp"
#include "externals/phantom/words.hpp"

#include <cstdio>
#include <string>
#include <utility>
#include <variant>

namespace tactus::phantom {
namespace {

constexpr double kMaxHostStall_s = 0.1; // longest time between calls of read(), normally every 5 ms

std::string newtons(double force_n) {
  char text[32];
  std::snprintf(text, sizeof text, "%.2g N", force_n);
  return text;
}

} // namespace

void ServoOutput::read(const Host& host) {
  const double now_s = devices::ServoThread::now_s();
  const bool stalled = now_s - collected_s_ > kMaxHostStall_s; // after a stall of the host, the
                                                               // servo may have stalled too
  if (session_.wall)
    clock_map_.follow(host.now_ms(), now_s);
  collected_s_ = now_s;
  if (session_.read_report() || stalled)
    report_s_ = now_s;
  drain_trace();
}

void ServoOutput::send_events(Host& host) {
  ServoRig& rig = session_.rig();
  const auto send_all = [&](auto& events, auto event) {
    for (int taken = 0; taken < 256 && events.pop(event); ++taken)
      std::visit([&](const auto& one) { send(one, host); }, event);
  };
  send_all(rig.servo.exchange().events, haptic::ServoEvent());
  send_all(rig.scene.events(), haptic::SceneEvent());
  rig.scene.collect();
  rig.network.collect();
  watch_queues(host);
}

void ServoOutput::servo_begins() noexcept { report_s_ = devices::ServoThread::now_s(); }

double ServoOutput::silence_s() const noexcept { return devices::ServoThread::now_s() - report_s_; }

/// Converts a time of the servo's clock to the patch's logical time, ms.
double ServoOutput::patch_ms(double servo_s) const noexcept {
  return session_.wall ? clock_map_.host_ms(servo_s) : servo_s * 1e3;
}

void ServoOutput::drain_trace() {
  haptic::Report report;
  for (int taken = 0; taken < 1024 && session_.exchange().trace.pop(report); ++taken)
    trace_.write(report, patch_ms(report.tick.time_s));
}

/// Reports entries that full queues have dropped, once a second.
void ServoOutput::watch_queues(Host& host) {
  const haptic::Exchange& exchange = session_.exchange();
  const std::uint64_t lost = exchange.events.dropped() + session_.rig().scene.events().dropped() +
                             exchange.trace.dropped();
  if (lost == lost_reported_ || host.now_ms() - last_loss_ms_ < 1000)
    return;
  last_loss_ms_ = host.now_ms();
  host.error("events: " + number_text(static_cast<double>(lost - lost_reported_)) +
             " events or trace rows were lost: the patch did not read them in time");
  lost_reported_ = lost;
}

void ServoOutput::send(const haptic::ButtonEvent& event, Host& host) const {
  reports_.send(kButton, {"button", static_cast<double>(event.number), event.on ? 1.0 : 0.0}, host);
}

void ServoOutput::send(const haptic::WatchdogEvent& event, Host& host) const {
  reports_.send(kStatus, {"status", "watchdog", event.on ? 1.0 : 0.0}, host);
}

void ServoOutput::send(const haptic::HitEvent& event, Host& host) const {
  const Vec3 p = event.point * 1e3, &n = event.normal;
  reports_.send(kHit,
                {"hit", message_time(patch_ms(event.time_s)), models_.name_of(event.key), p.x, p.y,
                 p.z, n.x, n.y, n.z, event.approach_m_per_s, event.slip_m_per_s},
                host);
}

void ServoOutput::send(const haptic::ContactEvent& event, Host& host) const {
  const Vec3& f = event.force_n;
  reports_.send(kContact,
                {"contact", message_time(patch_ms(event.time_s)), models_.name_of(event.key),
                 event.depth_m * 1e3, f.x, f.y, f.z},
                host);
}

void ServoOutput::send(const haptic::ReleaseEvent& event, Host& host) const {
  reports_.send(kRelease,
                {"release", message_time(patch_ms(event.time_s)), models_.name_of(event.key)},
                host);
}

bool ServoOutput::watch_chain(const haptic::Report& report, double force_limit_n,
                              std::string_view device, Host& host) {
  const auto begins = [&](std::string_view word, bool now, bool& before) {
    if (now == std::exchange(before, now))
      return false;
    reports_.send(kStatus, {"status", word, now ? 1.0 : 0.0}, host);
    return now;
  };
  const std::string name(device);
  if (begins("warm", report.derating, warm_))
    host.log(name + ": the motors are warm: force is limited to about " +
             newtons(report.derated_to_n) + " until they cool");
  if (begins("clipped", report.clipping, clipping_) && !std::exchange(clipping_logged_, true))
    host.log(name + ": " + newtons(report.asked_n) + " requested, limited to " +
             newtons(force_limit_n) +
             " (forcemax, or the device's peak); from now on only status clipped reports it");
  begins("braked", report.braking, braking_);
  return begins("frozen", report.frozen, frozen_);
}

void ServoOutput::send_position(const haptic::Workspace& workspace, bool always, Host& host) {
  const haptic::Report* const report = session_.report();
  if (!report)
    return;
  const Vec3 position = workspace.normalised(report->state.position);
  if (!always && sent_ && *sent_ == position)
    return;
  sent_ = position;
  host.send(2, {position.z});
  host.send(1, {position.y});
  host.send(0, {position.x});
}

void ServoOutput::send_values(const haptic::Report& report, bool all, bool has_rotation,
                              Host& host) const {
  const auto send_vector = [&host](std::string_view tag, const Vec3& v) {
    host.info({tag, v.x, v.y, v.z});
  };
  if (all || reports_.on(kMm))
    send_vector("mm", report.state.position * 1e3);
  if (all || reports_.on(kVel))
    send_vector("vel", report.state.velocity);
  if (all || reports_.on(kForce))
    send_vector("force", report.force_n);
  if (reports_.on(kRot) || (all && has_rotation))
    send_vector("rot", report.state.rotation);
}

void ServoOutput::send_timing(bool threaded, Host& host) {
  if (!reports_.on(kJitter) || host.now_ms() - last_timing_ms_ < 1000)
    return;
  last_timing_ms_ = host.now_ms();
  const auto late = session_.statistics(threaded).lateness;
  host.info({"jitter", late.mean_s() * 1e3, late.quantile_s(0.5) * 1e3, late.quantile_s(0.95) * 1e3,
             late.quantile_s(0.99) * 1e3, late.max_s() * 1e3});
}

void ServoOutput::send_statistics(bool threaded, Host& host) const {
  const haptic::ServoStatistics s = session_.statistics(threaded);
  const haptic::Exchange& exchange = session_.exchange();
  const haptic::Report& r = exchange.reports.latest();
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
  count("events_lost", exchange.events.dropped() + session_.rig().scene.events().dropped());
  count("trace_lost", exchange.trace.dropped());
  line("clock_drift_ppm", clock_map_.drift_ppm());
  count("clock_leaps", clock_map_.leaps());
  line("energy_j", r.energy_j);
  line("lowest_energy_j", r.lowest_energy_j);
}

void ServoOutput::trace(const Atom& file, Host& host) {
  if (!file.is_word)
    return host.error(expected("trace", file, "a file name or stop"));
  drain_trace();
  session_.exchange().tracing = false;
  if (const std::string rest = trace_.close(); !rest.empty())
    host.error("trace: " + rest);
  if (is(file, "stop"))
    return;
  if (const std::string refusal = trace_.open(host.new_file(file.word)); !refusal.empty())
    return host.error("trace " + std::string(file.word) + ": cannot be written: " + refusal);
  session_.exchange().tracing = true;
}

} // namespace tactus::phantom
