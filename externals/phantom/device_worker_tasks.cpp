#include "externals/phantom/device_worker_state.hpp"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <thread>

/// DeviceWorker's functions in its thread, where a driver's call may take any time.
namespace tactus::phantom {
namespace {

constexpr double kFirstPause_s = 0.25, kMaxPause_s = 4;
constexpr double kFall_s = 0.2; // time in which the force falls at the slew limit
constexpr double kOneHour_s = 3600;

} // namespace

/// The caller holds the lock.
void DeviceWorker::State::invalidate_ticket() {
  ticket = ~std::uint64_t{0};
  if (called && since_s == 0)
    since_s = devices::ServoThread::now_s();
  if (use && (called || ending))
    use->leave();
  changed.notify_all();
}

void DeviceWorker::State::cancel_unwanted() {
  Device opened;
  {
    const std::scoped_lock lock(mutex);
    if (since_s > 0)
      opened = called;
  }
  if (opened)
    opened->cancel();
}

bool DeviceWorker::State::is_current(std::uint64_t requested_ticket) const {
  const std::scoped_lock lock(mutex);
  return !ending && ticket == requested_ticket;
}

void DeviceWorker::State::begin_call(std::string what, Device opened) {
  const std::scoped_lock lock(mutex);
  since_s = opened && ticket != ~std::uint64_t{0} ? 0 : devices::ServoThread::now_s();
  call = std::move(what);
  called = std::move(opened);
}

void DeviceWorker::State::end_call() {
  const std::scoped_lock lock(mutex);
  call.clear();
  called.reset();
  since_s = 0;
}

void DeviceWorker::State::answer(Answer answer) {
  {
    const std::scoped_lock lock(mutex);
    answers.push_back(std::move(answer));
  }
  const std::scoped_lock lock(ready_mutex);
  if (ready)
    ready();
}

void DeviceWorker::State::work() {
  for (;;) {
    std::unique_lock lock(mutex);
    working = false;
    changed.wait(lock, [this] { return ending || !tasks.empty(); });
    if (tasks.empty()) {
      // Opened devices that the host's thread has not taken over.
      const std::deque<Answer> untaken = std::move(answers);
      answers.clear();
      lock.unlock();
      for (const Answer& one : untaken)
        if (one.kind == Answer::Kind::kOpened) {
          begin_call("closing the device", nullptr);
          one.device->close();
          end_call();
        }
      lock.lock();
      use.reset();
      has_thread = false;
      changed.notify_all();
      return;
    }
    working = true;
    Task task = std::move(tasks.front());
    tasks.pop_front();
    lock.unlock();
    execute(task);
  }
}

void DeviceWorker::State::execute(Task& task) {
  switch (task.kind) {
  case Task::Kind::kOpen:
    return open(task);
  case Task::Kind::kRun:
    return run(task);
  case Task::Kind::kClose: {
    Answer closed{Answer::Kind::kClosed, task.ticket, task.device};
    closed.released = end(task);
    return answer(std::move(closed));
  }
  case Task::Kind::kReopen:
    return reopen(task);
  case Task::Kind::kList:
    return list();
  }
}

/// Opens the device and marks its driver as in use. Empty, or the reason why not.
std::string DeviceWorker::State::try_open(const Task& task) {
  std::string refusal;
  auto entered = DriverUse::enter(
      *task.driver, [&] { return is_current(task.ticket); }, refusal);
  if (!entered)
    return refusal;
  const bool shared = entered->shared();
  {
    const std::scoped_lock lock(mutex);
    use = std::move(entered);
  }
  begin_call(std::string(task.driver->name) + ": opening the device", task.device);
  // problem() may load the driver's libraries, which would disturb another open device of it.
  refusal = shared ? std::string() : task.driver->problem();
  if (refusal.empty())
    refusal = task.device->open();
  end_call();
  const std::scoped_lock lock(mutex);
  if (refusal.empty())
    use->opened(task.device->identity());
  else
    use.reset();
  return refusal;
}

/// Reports the opened device, or closes it if the request was abandoned.
void DeviceWorker::State::announce(const Task& task) {
  bool still_requested = false;
  {
    const std::scoped_lock lock(mutex);
    still_requested = !ending && ticket == task.ticket;
    if (still_requested)
      answers.push_back({Answer::Kind::kOpened, task.ticket, task.device});
  }
  if (!still_requested) {
    Task close{Task::Kind::kClose, task.driver, task.device};
    static_cast<void>(end(close));
    return;
  }
  const std::scoped_lock lock(ready_mutex);
  if (ready)
    ready();
}

void DeviceWorker::State::open(const Task& task) {
  if (!is_current(task.ticket))
    return;
  std::string refusal = try_open(task);
  if (refusal.empty())
    return announce(task);
  answer({Answer::Kind::kRefused, task.ticket, task.device, std::move(refusal)});
}

void DeviceWorker::State::run(const Task& task) {
  if (!is_current(task.ticket))
    return;
  const Session& session = task.session;
  begin_call("starting the device's servo", nullptr);
  session.rig->guard.set_driven(true);
  std::string refusal =
      session.runner->start(session.rig->servo, *session.rig->device, task.period_s, session.rig);
  end_call();
  const bool runs = refusal.empty();
  answer({runs ? Answer::Kind::kRunning : Answer::Kind::kNotRunning, task.ticket,
          session.rig->device, std::move(refusal)});
}

/// Ends the session and closes the device. Returns whether the device accepted the zero force.
/// Waits for a call that hangs, since the device must not be closed during a call.
bool DeviceWorker::State::end(Task& task) {
  const std::string name = task.driver ? std::string(task.driver->name) + ": " : std::string();
  begin_call(name + "closing the device", nullptr);
  {
    const std::scoped_lock lock(mutex);
    if (use)
      use->leave();
  }
  bool released = true;
  if (const Session& session = task.session; session.runner) {
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
  task.device->close();
  end_call();
  const std::scoped_lock lock(mutex);
  use.reset();
  return released;
}

void DeviceWorker::State::reopen(Task& task) {
  static_cast<void>(end(task));
  std::string last;
  for (double pause_s = kFirstPause_s;; pause_s = std::min(2 * pause_s, kMaxPause_s)) {
    {
      std::unique_lock lock(mutex);
      changed.wait_for(lock, std::chrono::duration<double>(pause_s),
                       [&] { return ending || ticket != task.ticket; });
      if (ending || ticket != task.ticket)
        return;
    }
    std::string refusal = try_open(task);
    if (refusal.empty())
      return announce(task);
    if (refusal == last)
      continue;
    last = refusal;
    answer({Answer::Kind::kTrouble, task.ticket, task.device, std::move(refusal)});
  }
}

void DeviceWorker::State::list() {
  Answer all;
  all.kind = Answer::Kind::kListed;
  for (const devices::Driver* driver : devices::drivers()) {
    begin_call(std::string(driver->name) + ": listing devices", nullptr);
    DriverUse::Listed listed = DriverUse::list(*driver);
    end_call();
    if (listed.problem.empty())
      std::move(listed.found.begin(), listed.found.end(), std::back_inserter(all.found));
    else
      all.problems.emplace_back(driver->name, std::move(listed.problem));
  }
  answer(std::move(all));
}

} // namespace tactus::phantom
