#pragma once

#include "files/worker.hpp"

#include <atomic>
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tactus::reed {

/// Computes the nodes of a grid in the background, or step by step in the caller's thread. Nodes
/// are published in order: those below done() are final and may be read while others are computed.
/// No function waits.
class MapWorker {
public:
  /// Computes some nodes from `first` on and returns the number of final nodes; called until all
  /// are final. It must own its data: its last call may end after the worker is destroyed.
  using Portion = std::function<std::size_t(std::vector<double>& nodes, std::size_t first)>;

  /// Lets a thread compute another map, after the portion in progress. Returns an empty text, or an
  /// error text if no thread could be started; step() then does the work.
  [[nodiscard]] std::string start(std::size_t nodes, Portion portion) {
    make_grid(nodes, std::move(portion));
    const std::string reason = worker_.request(grid_);
    return reason.empty()
               ? reason
               : "cannot start a thread for the map (" + reason +
                     "); it is computed in the host's thread, which may interrupt the audio";
  }
  /// As start(), but without a thread: each step() computes one portion.
  void start_stepped(std::size_t nodes, Portion portion) {
    make_grid(nodes, std::move(portion));
    worker_.request_here(grid_);
  }
  void step() { worker_.step(0); }
  /// Ends the computation after the portion in progress.
  void cancel() { worker_.request_here(nullptr); }

  /// Returns, once, the reason why the map will not be finished; else an empty text.
  [[nodiscard]] std::string take_error() {
    const std::vector<std::string> sentences = worker_.take().sentences;
    return sentences.empty() ? std::string() : sentences.front();
  }
  [[nodiscard]] bool is_stepped() const noexcept { return worker_.is_here(); }
  [[nodiscard]] std::size_t done() const noexcept { return grid_->done; }
  [[nodiscard]] std::size_t size() const noexcept { return grid_->nodes.size(); }
  [[nodiscard]] bool finished() const noexcept { return done() == size(); }
  /// Requires index < done().
  [[nodiscard]] double node(std::size_t index) const noexcept { return grid_->nodes[index]; }

private:
  struct Grid {
    std::vector<double> nodes;
    Portion portion;
    std::atomic<std::size_t> done{0};
  };
  void make_grid(std::size_t nodes, Portion portion) {
    grid_ = std::make_shared<Grid>();
    grid_->nodes.assign(nodes, 0);
    grid_->portion = std::move(portion);
  }
  struct Job {
    using Request = std::shared_ptr<Grid>; ///< null if there is nothing to compute
    struct Answer {};                      ///< empty, since the nodes are in the grid
    static constexpr const char* kOutOfMemory = "not enough memory for the map";
    static double work(const Request& grid, Turn<Answer>&) {
      if (grid)
        grid->done = grid->portion(grid->nodes, grid->done);
      return grid && grid->done < grid->nodes.size() ? kDueNow : kNever;
    }
  };
  std::shared_ptr<Grid> grid_ = std::make_shared<Grid>();
  Worker<Job> worker_;
};

} // namespace tactus::reed
