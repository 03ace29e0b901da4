#include "externals/phantom/phantom.hpp"
#include "externals/phantom/tags.hpp"

#include <cstdio>
#include <utility>

/// Troubles of a real device: sent to the patch as `trouble DRIVER SENTENCE`, and once to the
/// host's window. Everything here runs in the host's thread.
namespace tactus {

using namespace phantom;

namespace {

constexpr double kPollInterval_ms = 50;
constexpr double kDebounce_ms = 100; // a trouble is reported after this time
constexpr double kClear_ms = 500;    // its end is reported after this time without trouble
constexpr double kStall_s = 1;       // a servo without a tick for this long is reported

} // namespace

/// Reports changes of the device's state flags and faults. The first report after opening always
/// includes whether the device is homed, since it may have been homed before this thread first read
/// the flags.
void Phantom::watch_device(Host& host) {
  if (!open())
    return;
  if (!has_report_)
    return watch_trouble(host);
  using haptic::State;
  const haptic::Report& report = exchange().reports.latest();
  const std::uint32_t now = report.state.flags;
  const std::uint32_t changed = flags_ ? now ^ *flags_ : now | State::kHomed;
  flags_ = now;
  constexpr std::pair<std::uint32_t, std::string_view> kWatched[] = {
      {State::kHomed, "homed"}, {State::kMotorsHot, "hot"}, {State::kForceLimited, "limited"}};
  for (const auto& [flag, word] : kWatched)
    if ((changed & flag) && reported_[kStatus])
      host.info({"status", word, (now & flag) ? 1.0 : 0.0});
  if (report.faults != faults_) {
    faults_ = report.faults;
    return report.fault == haptic::Fault::kReported ? handle_device_fault(host)
                                                    : handle_lost_device(host);
  }
  watch_trouble(host);
}

/// The device no longer answers: closes it and tries to open it again until it returns.
void Phantom::handle_lost_device(Host& host) {
  const std::string problem = device_->trouble();
  rig_->signals->configure(haptic::SignalLink::Time::kNone, 0, {});
  link_ = Link::kLost;
  switch_off();
  host.error(std::string(driver_name()) +
             ": the device no longer answers: check its cable and power. It is opened again "
             "when it returns; its motors stay off until motors 1" +
             (problem.empty() ? "" : " (" + problem + ")"));
  if (!problem.empty())
    send_trouble(trouble_ = problem, host);
  send_status("lost", host);
  const std::string refusal = worker(host).reopen(*driver_, {rig_, runner_}, device_, ++ticket_);
  replace_rig(host);
  host.wake_in(kWatchWorker, 0);
  if (!refusal.empty())
    closed(refusal, host);
}

/// The device reports a failure but still answers.
void Phantom::handle_device_fault(Host& host) {
  exchange().motors.emergency_stop();
  latch_stop();
  const std::string problem = device_->trouble();
  host.error("the device has failed and its motors stay off until motors 1: " +
             (problem.empty() ? std::string(driver_name()) + ": check the device first" : problem));
  if (!problem.empty())
    send_trouble(trouble_ = problem, host);
  if (reported_[kStatus])
    host.info({"status", "fault", 1.0});
  send_estop(host);
}

/// An empty sentence reports the end of a trouble.
void Phantom::send_trouble(std::string_view sentence, Host& host) const {
  if (reported_[kError])
    host.info({"trouble", driver_name(), sentence.empty() ? "-" : sentence});
}

void Phantom::watch_trouble(Host& host) {
  const double now_ms = host.now_ms();
  if (now_ms - trouble_polled_ms_ < kPollInterval_ms)
    return;
  trouble_polled_ms_ = now_ms;
  const bool still = running_ && devices::ServoThread::now_s() - report_s_ > kStall_s;
  std::string problem = still ? std::string(driver_name()) +
                                    ": the servo has stopped: a call of the driver does not "
                                    "return, or the driver no longer calls back; close the device, "
                                    "switch it off and on, and open it again"
                              : device_->trouble();
  if (problem != driver_trouble_) {
    driver_trouble_ = std::move(problem);
    trouble_ms_ = now_ms;
  }
  const double lasts_ms = now_ms - trouble_ms_;
  if (driver_trouble_ == trouble_ ||
      lasts_ms < (driver_trouble_.empty() ? kClear_ms : kDebounce_ms))
    return;
  trouble_ = driver_trouble_;
  send_trouble(trouble_, host);
  if (!trouble_.empty())
    host.log(trouble_);
}

/// Reports how the force chain changes the force, so that the user knows why the force felt differs
/// from the patch's request. Clipping is logged once, warm motors and a freeze each time.
void Phantom::watch_chain(Host& host) {
  const haptic::Report& report = exchange().reports.latest();
  if (!open() || !has_report_)
    return;
  const auto changed = [&](std::string_view word, bool now, bool& before) {
    if (now == std::exchange(before, now))
      return false;
    if (reported_[kStatus])
      host.info({"status", word, now ? 1.0 : 0.0});
    return now;
  };
  const auto newtons = [](double force_n) {
    char text[32];
    std::snprintf(text, sizeof text, "%.2g N", force_n);
    return std::string(text);
  };
  const std::string name(driver_name());
  if (changed("warm", report.derating, warm_reported_))
    host.log(name + ": the motors are warm: force is limited to about " +
             newtons(report.derated_to_n) + " until they cool");
  if (changed("clipped", report.clipping, clipping_reported_) &&
      !std::exchange(clipping_logged_, true))
    host.log(name + ": " + newtons(report.asked_n) + " requested, limited to " +
             newtons(settings_.chain.force_limit_n) +
             " (forcemax, or the device's peak); from now on only status clipped reports it");
  changed("braked", report.braking, braking_reported_);
  if (changed("frozen", report.frozen, frozen_reported_)) {
    switch_off();
    host.error(name + ": the host froze for longer than the watchdog's time: no force until "
                      "motors 1 (with resume 1 it returns automatically)");
  }
}

} // namespace tactus
