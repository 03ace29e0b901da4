#pragma once

#include "core/modal/body/body_model.hpp"

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace tactus::modal {

/// Reads tables and makes models in a thread of its own, or at once. Of requests that wait only the
/// last load, the last board and the last settings count.
class TableWorker {
public:
  /// What the body lies on from now on.
  struct Board {
    std::string path, name; ///< empty: nothing
    Vec3 displacement_m{};  ///< in the body's axes
  };
  struct Request {
    std::string path; ///< empty: only a new model of the same table, or another board
    std::string name; ///< of the file, as the user wrote it
    std::shared_ptr<const LoadedTable> table;
    BodySettings settings;
    std::optional<Board> board; ///< none: as it is
    /// `table` is the body of this one in another shape, which it is to replace; null: it is not.
    std::shared_ptr<const LoadedTable> replaces;
  };
  struct Result {
    std::string refusal; ///< a sentence when something could not be read
    std::shared_ptr<const LoadedTable> table;
    std::unique_ptr<BodyModel> model;
    bool loaded = false, board_loaded = false; ///< read now
    std::string path;                          ///< of the body that was loaded
  };

  TableWorker() = default;
  ~TableWorker();
  TableWorker(const TableWorker&) = delete;
  TableWorker& operator=(const TableWorker&) = delete;

  /// `ready` is called in the worker's thread when a result waits. Empty when it is on its way,
  /// else why there is no thread for it: the caller may carry it out itself.
  [[nodiscard]] std::string request(const Request& request, std::function<void()> ready);
  [[nodiscard]] std::optional<Result> take();
  /// The work itself.
  [[nodiscard]] static Result carry_out(const Request& request);

private:
  void work(const std::stop_token& stop);
  void follow(Request& request) const;

  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::optional<Request> waiting_;
  std::optional<Result> done_;
  /// The table that waits in `done_` and the one that it follows: requests made meanwhile mean it.
  std::shared_ptr<const LoadedTable> pending_before_, pending_table_;
  std::function<void()> ready_;
  std::jthread thread_;
};

} // namespace tactus::modal
