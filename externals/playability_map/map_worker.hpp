#pragma once

#include "files/background_thread.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tactus::reed {

/// Computes the nodes of a grid in the background, or step by step in the caller's thread.
/// Nodes are published in order: those below done() are final and may be read meanwhile. Nothing
/// here waits.
class MapWorker {
public:
  /// Computes some nodes from `first` on and returns the number of final nodes; called until that
  /// is all of them. It holds what it uses: its last call may end after the worker.
  using Portion = std::function<std::size_t(std::vector<double>& nodes, std::size_t first)>;

  /// Cancels the present computation and starts a new one in a thread. Returns an error text when
  /// no thread could be started, after which step() does the work; else empty.
  [[nodiscard]] std::string start(std::size_t nodes, Portion portion) {
    start_stepped(nodes, std::move(portion));
    grid_->running = true;
    stepped_ = false;
    const std::string reason = thread_.start(grid_);
    if (reason.empty())
      return {};
    grid_->running = false;
    stepped_ = true;
    return "no thread starts for the map (" + reason +
           "); it is computed in the host's time, which the audio may miss";
  }
  /// The same without a thread: each step() does one portion.
  void start_stepped(std::size_t nodes, Portion portion) {
    cancel();
    grid_ = std::make_shared<Grid>();
    grid_->nodes.assign(nodes, 0);
    grid_->portion = std::move(portion);
    stepped_ = true;
  }
  void step() {
    if (stepped_ && !finished())
      grid_->compute();
  }
  /// The thread ends after the portion in progress; until then it is not idle().
  void request_stop() noexcept {
    stepped_ = false;
    grid_->stop = true;
  }
  /// The same, and it is idle() at once.
  void cancel() {
    stepped_ = false;
    thread_.end();
  }

  /// Whether no computation is in progress.
  [[nodiscard]] bool idle() const noexcept {
    return stepped_ ? finished() : !(thread_.running() && grid_->running);
  }
  [[nodiscard]] bool is_stepped() const noexcept { return stepped_; }
  [[nodiscard]] std::size_t done() const noexcept { return grid_->done; }
  [[nodiscard]] std::size_t size() const noexcept { return grid_->nodes.size(); }
  [[nodiscard]] bool finished() const noexcept { return done() == size(); }
  /// index < done().
  [[nodiscard]] double node(std::size_t index) const noexcept { return grid_->nodes[index]; }

private:
  struct Grid : BackgroundState {
    void work() override {
      while (done < nodes.size() && !stop)
        compute();
      running = false;
    }
    void compute() { done = portion(nodes, done); }

    std::vector<double> nodes;
    Portion portion;
    std::atomic<std::size_t> done{0};
    std::atomic<bool> running{false};
  };
  std::shared_ptr<Grid> grid_ = std::make_shared<Grid>();
  bool stepped_ = false;
  BackgroundThread thread_;
};

} // namespace tactus::reed
