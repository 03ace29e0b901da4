#include "externals/phantom/device_worker.hpp"

#include "devices/signals_held_back.hpp"

#include <algorithm>
#include <chrono>

namespace tactus::phantom {

namespace {
constexpr double kFirstPause_s = 0.25, kLongestPause_s = 4;
} // namespace

void DeviceWorker::give(Task task) {
  const std::scoped_lock lock(mutex_);
  if (ending_)
    return;
  if (task.ticket > 0)
    ticket_ = task.ticket;
  tasks_.push_back(std::move(task));
  if (!thread_.joinable()) {
    const devices::SignalsHeldBack held; // so do the drivers' threads, which the worker starts
    thread_ = std::thread([this] { work(); });
  }
  wake_.notify_all();
}

void DeviceWorker::open(const devices::Driver& driver, Device device, std::uint64_t ticket) {
  give({Task::Kind::kOpen, &driver, std::move(device), ticket});
}
void DeviceWorker::reopen(const devices::Driver& driver, Device device, std::uint64_t ticket) {
  give({Task::Kind::kReopen, &driver, std::move(device), ticket});
}
void DeviceWorker::close(Device device) {
  give({Task::Kind::kClose, nullptr, std::move(device), 0});
}
void DeviceWorker::list() { give({Task::Kind::kList, nullptr, nullptr, 0}); }

void DeviceWorker::forget() {
  const std::scoped_lock lock(mutex_);
  ticket_ = ~std::uint64_t{0};
  wake_.notify_all();
}

std::optional<DeviceWorker::Answer> DeviceWorker::take() {
  const std::scoped_lock lock(mutex_);
  if (answers_.empty())
    return std::nullopt;
  Answer answer = std::move(answers_.front());
  answers_.pop_front();
  return answer;
}

void DeviceWorker::finish() noexcept {
  {
    const std::scoped_lock lock(mutex_);
    ending_ = true;
    wake_.notify_all();
  }
  if (thread_.joinable())
    thread_.join();
  for (const Answer& answer : answers_)
    if (answer.kind == Answer::Kind::kOpened)
      answer.device->close();
  answers_.clear();
}

void DeviceWorker::answer(Answer answer) {
  {
    const std::scoped_lock lock(mutex_);
    answers_.push_back(std::move(answer));
  }
  ready_();
}

void DeviceWorker::work() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return ending_ || !tasks_.empty(); });
    if (tasks_.empty())
      return;
    const Task task = std::move(tasks_.front());
    tasks_.pop_front();
    if (ending_ && task.kind != Task::Kind::kClose)
      continue;
    lock.unlock();
    carry_out(task);
    lock.lock();
  }
}

void DeviceWorker::carry_out(const Task& task) {
  switch (task.kind) {
  case Task::Kind::kOpen:
    return open_once(task);
  case Task::Kind::kReopen:
    return open_in_time(task);
  case Task::Kind::kClose:
    return task.device->close();
  case Task::Kind::kList: {
    Answer all;
    all.kind = Answer::Kind::kListed;
    for (const devices::Driver* driver : devices::drivers()) {
      std::string obstacle = driver->obstacle();
      if (!obstacle.empty()) {
        all.obstacles.emplace_back(driver->name, std::move(obstacle));
        continue;
      }
      std::vector<devices::Found> found = driver->list();
      std::move(found.begin(), found.end(), std::back_inserter(all.found));
    }
    return answer(std::move(all));
  }
  }
}

std::string DeviceWorker::opened(const Task& task) {
  std::string obstacle = task.driver->obstacle();
  return obstacle.empty() ? task.device->open() : obstacle;
}

bool DeviceWorker::wanted(std::uint64_t ticket) {
  const std::scoped_lock lock(mutex_);
  return !ending_ && ticket_ == ticket;
}

/// An open device, unless nobody wants it any more.
void DeviceWorker::announce(const Task& task) {
  bool asked_for = false;
  {
    const std::scoped_lock lock(mutex_);
    asked_for = !ending_ && ticket_ == task.ticket;
    if (asked_for)
      answers_.push_back({Answer::Kind::kOpened, task.ticket, task.device, {}, {}, {}});
  }
  if (asked_for)
    ready_();
  else
    task.device->close();
}

void DeviceWorker::open_once(const Task& task) {
  if (!wanted(task.ticket))
    return;
  std::string refusal = opened(task);
  if (refusal.empty())
    return announce(task);
  answer({Answer::Kind::kRefused, task.ticket, task.device, std::move(refusal), {}, {}});
}

void DeviceWorker::open_in_time(const Task& task) {
  task.device->close();
  for (double pause_s = kFirstPause_s;; pause_s = std::min(2 * pause_s, kLongestPause_s)) {
    {
      std::unique_lock lock(mutex_);
      wake_.wait_for(lock, std::chrono::duration<double>(pause_s), [&] {
        return ending_ || ticket_ != task.ticket ||
               std::any_of(tasks_.begin(), tasks_.end(),
                           [](const Task& t) { return t.kind == Task::Kind::kList; });
      });
      if (ending_ || ticket_ != task.ticket)
        return;
    }
    if (opened(task).empty())
      return announce(task);
    // Who asks for a list meanwhile does not wait until the device returns.
    std::unique_lock lock(mutex_);
    const auto list = std::find_if(tasks_.begin(), tasks_.end(),
                                   [](const Task& t) { return t.kind == Task::Kind::kList; });
    if (list == tasks_.end())
      continue;
    const Task other = *list;
    tasks_.erase(list);
    lock.unlock();
    carry_out(other);
  }
}

} // namespace tactus::phantom
