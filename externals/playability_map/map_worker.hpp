#pragma once

#include "externals/normal_priority.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <string>
#include <system_error>
#include <thread>
#include <vector>

namespace tactus::reed {

/// Computes the nodes of a grid in a thread of normal priority, or step by step in the caller's.
/// Nodes are published in order: those below done() are final and may be read meanwhile. Only
/// cancel() and start() wait, for the portion in progress; start() does not wait while idle().
class MapWorker {
public:
  /// Computes some nodes from `first` on and returns the number of final nodes; called until that
  /// is all of them. Runs in the worker's thread, or in the caller's of step().
  using Portion = std::function<std::size_t(std::vector<double>& nodes, std::size_t first)>;

  ~MapWorker() { cancel(); }

  /// Cancels the present computation and starts a new one in a thread. Returns an error text when
  /// no thread could be started, after which step() does the work; else empty.
  [[nodiscard]] std::string start(std::size_t nodes, Portion portion) {
    reset(nodes);
    running_.store(true, std::memory_order_relaxed);
    try {
      thread_ = std::jthread([this, work = portion](const std::stop_token& stop) {
        set_normal_priority();
        std::size_t done = 0;
        while (done < nodes_.size() && !stop.stop_requested()) {
          done = work(nodes_, done);
          done_.store(done, std::memory_order_release);
        }
        running_.store(false, std::memory_order_release);
      });
    } catch (const std::system_error& error) {
      running_.store(false, std::memory_order_relaxed);
      steps_ = std::move(portion);
      return std::string("no thread starts for the map (") + error.what() +
             "); it is computed in the host's time, which the audio may miss";
    }
    return {};
  }
  /// The same without a thread: each step() does one portion.
  void start_stepped(std::size_t nodes, Portion portion) {
    reset(nodes);
    steps_ = std::move(portion);
  }
  void step() {
    if (steps_ && !finished())
      done_.store(steps_(nodes_, done()), std::memory_order_release);
  }
  /// Does not wait: the thread ends after the portion in progress.
  void request_stop() {
    steps_ = nullptr;
    thread_.request_stop();
  }
  void cancel() {
    steps_ = nullptr;
    if (!thread_.joinable())
      return;
    thread_.request_stop();
    thread_.join();
  }

  /// Whether no computation is in progress.
  [[nodiscard]] bool idle() const noexcept {
    return is_stepped() ? finished() : !running_.load(std::memory_order_acquire);
  }
  [[nodiscard]] bool is_stepped() const noexcept { return static_cast<bool>(steps_); }
  [[nodiscard]] std::size_t done() const noexcept { return done_.load(std::memory_order_acquire); }
  [[nodiscard]] std::size_t size() const noexcept { return nodes_.size(); }
  [[nodiscard]] bool finished() const noexcept { return done() == nodes_.size(); }
  /// index < done().
  [[nodiscard]] double node(std::size_t index) const noexcept { return nodes_[index]; }

private:
  void reset(std::size_t nodes) {
    cancel();
    nodes_.assign(nodes, 0);
    done_.store(0, std::memory_order_release);
  }
  std::vector<double> nodes_;

  std::atomic<std::size_t> done_{0};
  std::atomic<bool> running_{false};
  Portion steps_;
  std::jthread thread_;
};

} // namespace tactus::reed
