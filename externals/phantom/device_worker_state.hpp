#pragma once

#include "externals/phantom/device_worker.hpp"

#include <condition_variable>
#include <deque>
#include <mutex>

namespace tactus::phantom {

/// One request to the worker's thread.
struct DeviceWorker::Task {
  enum class Kind { kOpen, kRun, kClose, kReopen, kList };
  Kind kind;
  const devices::Driver* driver = nullptr;
  Device device{};
  Session session{};
  std::uint64_t ticket = 0;
  double period_s = 0;
};

/// The state that a worker shares with its thread, and the thread's functions.
struct DeviceWorker::State {
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<Task> tasks;
  std::deque<Answer> answers;
  std::uint64_t ticket = 0; ///< the newest requested
  bool ending = false;      ///< no new task
  bool has_thread = false, working = false;
  // the running call of a driver
  std::string call;   ///< its description; empty: none
  Device called;      ///< the device, if the call opens one
  double since_s = 0; ///< when it began or, of an opening, was abandoned; 0: still requested
  std::unique_ptr<DriverUse> use;

  std::mutex ready_mutex; ///< locked while `ready` is called, which returns at once
  std::function<void()> ready;

  void invalidate_ticket();
  void cancel_unwanted();

  // The functions below run in the worker's thread.
  void work();

private:
  void execute(Task& task);
  void answer(Answer answer);
  [[nodiscard]] bool is_current(std::uint64_t requested_ticket) const;
  void begin_call(std::string what, Device opened);
  void end_call();
  [[nodiscard]] std::string try_open(const Task& task);
  void announce(const Task& task);
  void open(const Task& task);
  void run(const Task& task);
  [[nodiscard]] bool end(Task& task);
  void reopen(Task& task);
  void list();
};

} // namespace tactus::phantom
