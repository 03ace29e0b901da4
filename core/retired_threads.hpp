#pragma once

#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

namespace tactus {

/// Threads that outlive their owners, until they end: an owner that is deleted in the host's thread
/// need not wait for its thread. Such a thread must own all that it uses.
class RetiredThreads {
public:
  /// `ended`: set by the thread as its last act.
  static void add(std::thread thread, std::shared_ptr<const std::atomic<bool>> ended) {
    static RetiredThreads threads;
    const std::lock_guard lock(threads.mutex_);
    threads.join_ended();
    threads.entries_.push_back({std::move(thread), std::move(ended)});
  }

private:
  /// At the end of the program: waits for all threads together, one second at most.
  ~RetiredThreads() {
    constexpr int kMaxWaits = 100;
    for (int i = 0; i < kMaxWaits && !entries_.empty(); ++i) {
      join_ended();
      if (!entries_.empty())
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    for (Entry& entry : entries_)
      entry.thread.detach();
  }
  void join_ended() {
    std::erase_if(entries_, [](Entry& entry) {
      if (!*entry.ended)
        return false;
      entry.thread.join(); // has returned, or is about to
      return true;
    });
  }

  struct Entry {
    std::thread thread;
    std::shared_ptr<const std::atomic<bool>> ended;
  };
  std::mutex mutex_{};
  std::vector<Entry> entries_{};
};

} // namespace tactus
