#pragma once

#include "core/retired_threads.hpp"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

#if defined(__unix__) || defined(__APPLE__)
#include <pthread.h>
#include <sched.h>
#endif

namespace tactus {

/// Data shared by a background thread and its owner; exists until both have ended.
struct BackgroundState {
  std::mutex mutex;
  std::condition_variable changed;
  std::atomic<bool> stop{false}; ///< read between the pieces of a computation
  std::function<void()> ready;   ///< null once the owner has gone; guarded by `mutex`

  BackgroundState() = default;
  virtual ~BackgroundState() = default;
  BackgroundState(const BackgroundState&) = delete;
  BackgroundState& operator=(const BackgroundState&) = delete;

  /// The thread's work, until `stop`.
  virtual void work() = 0;
  /// Ends the work; called by the owner.
  void end() noexcept {
    {
      const std::lock_guard lock(
          mutex); // without it, the thread could test `stop` before and wait after this
      stop = true;
      ready = nullptr;
    }
    changed.notify_all();
  }
};

/// A thread of normal priority that computes for an object of a host, whatever the priority of the
/// thread that starts it. Its owner never waits for it: when the owner has gone, the thread ends
/// after the piece in progress. At the end of the program the thread has one second to do so.
class BackgroundThread {
public:
  BackgroundThread() = default;
  ~BackgroundThread() { end(); }
  BackgroundThread(const BackgroundThread&) = delete;
  BackgroundThread& operator=(const BackgroundThread&) = delete;

  [[nodiscard]] bool running() const noexcept { return thread_.joinable(); }
  /// Returns an empty text, or the reason why the system starts no thread.
  [[nodiscard]] std::string start(std::shared_ptr<BackgroundState> state) {
    end();
    ended_ = std::make_shared<std::atomic<bool>>(false);
    try {
      thread_ = std::thread([held = state, ended = ended_]() mutable {
        set_normal_priority();
        held->work();
        held = nullptr;
        *ended = true;
      });
    } catch (const std::system_error& error) {
      return error.what();
    }
    state_ = std::move(state);
    return {};
  }
  void end() {
    if (!thread_.joinable())
      return;
    std::exchange(state_, nullptr)->end();
    RetiredThreads::add(std::move(thread_), std::move(ended_));
  }

private:
  static void set_normal_priority() noexcept {
#if defined(__unix__) || defined(__APPLE__)
    sched_param normal_priority{};
    (void)pthread_setschedparam(pthread_self(), SCHED_OTHER, &normal_priority);
#endif
  }
  std::shared_ptr<BackgroundState> state_;
  std::shared_ptr<std::atomic<bool>> ended_;
  std::thread thread_;
};

} // namespace tactus
