#include "externals/phantom/device_worker.hpp"

#include "devices/scoped_signal_mask.hpp"
#include "externals/phantom/device_worker_state.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <system_error>
#include <thread>

/// DeviceWorker's functions for the host's thread; none of them waits for a driver.
namespace tactus::phantom {
namespace {

constexpr auto kPollInterval = std::chrono::milliseconds(5);

/// The workers with a thread, for join_all() at the end of the program. Never destroyed.
struct Table {
  std::mutex mutex;
  std::vector<std::weak_ptr<void>> all;
};
Table& table() {
  static auto* const made = new Table;
  return *made;
}

} // namespace

DeviceWorker::DeviceWorker(std::function<void()> ready) : state_(std::make_shared<State>()) {
  state_->ready = std::move(ready);
}

DeviceWorker::~DeviceWorker() {
  {
    const std::scoped_lock lock(state_->ready_mutex);
    state_->ready = nullptr;
  }
  const std::scoped_lock lock(state_->mutex);
  state_->ending = true;
  state_->invalidate_ticket();
}

std::string DeviceWorker::enqueue(Task task) {
  const std::scoped_lock lock(state_->mutex);
  if (state_->ending)
    return "the program is ending";
  if (!state_->has_thread) {
    const devices::ScopedSignalMask
        mask; // the drivers' threads inherit it, since the worker starts them
    try {
      std::thread([state = state_] { state->work(); }).detach();
    } catch (const std::system_error& error) {
      return std::string("cannot start the thread for devices (") + error.what() +
             "): close other programs or raise the limit on threads";
    }
    state_->has_thread = true;
    const std::scoped_lock table_lock(table().mutex);
    std::erase_if(table().all, [](const auto& one) { return one.expired(); });
    table().all.push_back(state_);
  }
  if (task.ticket > 0)
    state_->ticket = task.ticket;
  state_->tasks.push_back(std::move(task));
  state_->changed.notify_all();
  return {};
}

std::string DeviceWorker::open(const devices::Driver& driver, Device device, std::uint64_t ticket) {
  return enqueue({Task::Kind::kOpen, &driver, std::move(device), {}, ticket});
}
std::string DeviceWorker::run(Session session, double period_s, std::uint64_t ticket) {
  return enqueue({Task::Kind::kRun, nullptr, {}, std::move(session), ticket, period_s});
}
std::string DeviceWorker::close(const devices::Driver* driver, Session session, Device device) {
  return enqueue({Task::Kind::kClose, driver, std::move(device), std::move(session)});
}
std::string DeviceWorker::reopen(const devices::Driver& driver, Session session, Device device,
                                 std::uint64_t ticket) {
  return enqueue({Task::Kind::kReopen, &driver, std::move(device), std::move(session), ticket});
}
std::string DeviceWorker::list() { return enqueue({Task::Kind::kList}); }

void DeviceWorker::abandon() {
  const std::scoped_lock lock(state_->mutex);
  state_->invalidate_ticket();
}

std::optional<DeviceWorker::Answer> DeviceWorker::take() {
  const std::scoped_lock lock(state_->mutex);
  if (state_->answers.empty())
    return std::nullopt;
  Answer answer = std::move(state_->answers.front());
  state_->answers.pop_front();
  return answer;
}

bool DeviceWorker::busy() const {
  const std::scoped_lock lock(state_->mutex);
  return state_->working || !state_->tasks.empty();
}

void DeviceWorker::cancel_unwanted() { state_->cancel_unwanted(); }

std::string DeviceWorker::overdue(double limit_s) const {
  const std::scoped_lock lock(state_->mutex);
  const bool late =
      state_->since_s > 0 && devices::ServoThread::now_s() - state_->since_s > limit_s;
  return late ? state_->call : std::string();
}

bool DeviceWorker::finish(double seconds) noexcept {
  {
    const std::scoped_lock lock(state_->mutex);
    state_->ending = true;
    state_->invalidate_ticket();
  }
  const double end_s = devices::ServoThread::now_s() + seconds;
  for (;;) {
    state_->cancel_unwanted();
    std::unique_lock lock(state_->mutex);
    if (!state_->has_thread)
      return true;
    if (devices::ServoThread::now_s() > end_s)
      return false;
    state_->changed.wait_for(lock, kPollInterval);
  }
}

void DeviceWorker::join_all(double seconds) noexcept {
  std::vector<std::shared_ptr<State>> all;
  {
    const std::scoped_lock lock(table().mutex);
    for (const auto& one : table().all)
      if (auto state = std::static_pointer_cast<State>(one.lock()))
        all.push_back(std::move(state));
  }
  const auto ask_to_end = [](State& state) {
    const std::scoped_lock lock(state.mutex);
    state.ending = true;
    state.invalidate_ticket();
    return !state.has_thread;
  };
  const double end_s = devices::ServoThread::now_s() + seconds;
  for (;;) {
    std::erase_if(all, [&](const auto& state) { return ask_to_end(*state); });
    if (all.empty() || devices::ServoThread::now_s() > end_s)
      break;
    for (const auto& state : all)
      state->cancel_unwanted();
    std::this_thread::sleep_for(kPollInterval);
  }
  for (const auto& state : all) {
    const std::scoped_lock lock(state->mutex);
    std::fprintf(stderr, "phantom: %s has not returned; the program ends without it\n",
                 state->call.empty() ? "a device's driver" : state->call.c_str());
  }
}

} // namespace tactus::phantom
