#include "externals/phantom/device/device_worker.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>

/// The work of the devices' threads, in which a driver's call may take any time.
namespace tactus::phantom {
namespace {

constexpr double kFirstPause_s = 0.25, kMaxPause_s = 4;
constexpr double kFall_s = 0.2; // longest time for the force to fall at the slew limit
constexpr double kOneHour_s = 3600;

} // namespace

double DeviceJob::work(const Request& request, Turn<Answer>& turn) {
  if (open_.device && open_.ticket != request.ticket) {
    if (!close() && !request.persists) // a lost device accepts no force
      turn.say("close: the device did not accept the final zero force; it may be unplugged");
    return kDueNow;
  }
  if (!request.device)
    return kNever;
  if (!open_.device)
    return open(request, turn);
  if (request.session.runner && !open_.session.runner)
    run(request, turn);
  return kNever;
}

void DeviceJob::end() {
  if (open_.device)
    static_cast<void>(close());
  DriverCalls::set_running(calls_, false);
}

double DeviceJob::open(const Request& request, Turn<Answer>& turn) {
  if (std::exchange(ticket_, request.ticket) != request.ticket) {
    pause_s_ = kFirstPause_s;
    reported_.reset();
    if (request.persists)
      return turn.now_s() + pause_s_;
  }
  std::string refusal = try_open(request, turn);
  if (refusal.empty()) {
    open_ = {request.ticket, request.driver, request.device};
    turn.hand_over({Answer::Kind::kOpened, request.ticket});
    return kNever;
  }
  if (!request.persists) {
    turn.hand_over({Answer::Kind::kRefused, request.ticket, std::move(refusal)});
    return kNever;
  }
  if (reported_ != refusal)
    turn.hand_over({Answer::Kind::kTrouble, request.ticket, refusal});
  reported_ = std::move(refusal);
  pause_s_ = std::min(2 * pause_s_, kMaxPause_s);
  return devices::ServoThread::now_s() + pause_s_;
}

/// Opens the device and marks its driver as in use. Returns an empty text, or the reason why it
/// cannot be opened.
std::string DeviceJob::try_open(const Request& request, const Turn<Answer>& turn) {
  std::string refusal;
  auto use = DriverUse::enter(
      *request.driver, [&turn] { return !turn.is_superseded(); }, refusal);
  if (!use)
    return refusal;
  const bool shared = use->shared();
  calls_->set_use(std::move(use));
  {
    const DriverCalls::Call call(*calls_,
                                 std::string(request.driver->name) + ": opening the device",
                                 request.device, request.ticket);
    // problem() may load the driver's libraries, which would disturb another open device of that
    // driver.
    refusal = shared ? std::string() : request.driver->problem();
    if (refusal.empty())
      refusal = request.device->open();
  }
  if (refusal.empty())
    calls_->opened(request.device->identity());
  else
    calls_->set_use(nullptr);
  return refusal;
}

void DeviceJob::run(const Request& request, Turn<Answer>& turn) {
  open_.session = request.session;
  ServoRig& rig = *request.session.rig;
  rig.guard.set_driven(true);
  std::string refusal;
  {
    const DriverCalls::Call call(*calls_, "starting the device's servo");
    refusal = request.session.runner->start(rig.servo, *rig.device, request.period_s,
                                            request.session.rig);
  }
  turn.hand_over({refusal.empty() ? Answer::Kind::kRunning : Answer::Kind::kNotRunning,
                  request.ticket, std::move(refusal)});
}

/// Ends the session and closes the device. Returns whether the device accepted the zero force.
/// Waits for a call that hangs, since the device must not be closed during a call.
bool DeviceJob::close() {
  const Request closed = std::exchange(open_, {});
  const DriverCalls::Call call(*calls_, std::string(closed.driver->name) + ": closing the device");
  calls_->leave();
  bool released = true;
  if (const Session& session = closed.session; session.runner) {
    const double give_up_s = devices::ServoThread::now_s() + kFall_s;
    while (session.runner->running() &&
           !session.rig->servo.exchange().motors.zero_force_confirmed() &&
           devices::ServoThread::now_s() < give_up_s)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    while (!session.runner->stop(kOneHour_s)) {
    }
    session.rig->guard.set_driven(false);
    released = session.runner->released();
  }
  closed.device->close();
  calls_->set_use(nullptr);
  return released;
}

double ListJob::work(const Request&, Turn<Answer>& turn) {
  Answer all;
  for (const devices::Driver* driver : devices::drivers()) {
    const DriverCalls::Call call(*calls_, std::string(driver->name) + ": listing devices");
    DriverUse::Listed listed = DriverUse::list(*driver);
    if (listed.problem.empty())
      std::move(listed.found.begin(), listed.found.end(), std::back_inserter(all.found));
    else
      all.problems.emplace_back(driver->name, std::move(listed.problem));
  }
  turn.hand_over(std::move(all));
  return kNever;
}

} // namespace tactus::phantom
