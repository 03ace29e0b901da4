#pragma once

#include "core/modal/body/body_model.hpp"
#include "files/background_thread.hpp"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace tactus::modal {

/// Reads tables and builds models in the background, or at once. Waiting requests are merged: the
/// last load, the last board and the last settings count.
class TableWorker {
public:
  /// A new board for the body.
  struct Board {
    std::string path, name; ///< empty: nothing
    Vec3 displacement_m{};  ///< in the body's axes
  };
  struct Request {
    std::string path; ///< empty: only a new model of the same table, or another board
    std::string name; ///< of the file, as the user wrote it
    std::shared_ptr<const LoadedTable> table;
    BodySettings settings;
    std::optional<Board> board; ///< none: unchanged
    /// If `table` is another shape of the present body: the table that it replaces; else null.
    std::shared_ptr<const LoadedTable> replaces;
    std::uint64_t number = 0; ///< counted by request()
  };
  struct Result {
    /// Why something could not be read, or why the model radiates in the default way; else empty.
    std::string refusal;
    std::shared_ptr<const LoadedTable> table;
    std::unique_ptr<BodyModel> model;
    bool loaded = false, board_loaded = false; ///< read now
    std::string path;                          ///< of the body that was loaded
    std::string board_name;                    ///< of the board, as the user wrote it
    std::uint64_t number = 0;                  ///< of the last request whose settings it answers
  };

  /// Queues a request. `ready` is called in the worker's thread when a result waits. Returns empty,
  /// or why no thread could be started: the caller may then call execute().
  [[nodiscard]] std::string request(const Request& request, std::function<void()> ready);
  [[nodiscard]] std::optional<Result> take();
  /// The number of the last request. The caller's thread.
  [[nodiscard]] std::uint64_t requested() const noexcept { return requested_; }
  /// Whether a table is being read while there is none yet, until its result has been taken. Any
  /// thread; waits for nothing.
  [[nodiscard]] bool loads_first() const noexcept { return state_->loads_first.load(); }
  /// Why a table cannot radiate as asked; empty: it can. `instead`: what happens then.
  [[nodiscard]] static std::string radiation_refusal(const LoadedTable& table, Radiation radiation,
                                                     Radiation instead);
  /// Executes a request in the caller's thread.
  [[nodiscard]] static Result execute(const Request& request);

private:
  std::uint64_t requested_ = 0;
  struct State : BackgroundState {
    void work() override;
    void follow(Request& request) const;

    std::optional<Request> waiting;
    std::optional<Result> done;
    /// The table in `done` and the one that it replaces: requests for that one are for the new one.
    std::shared_ptr<const LoadedTable> pending_before, pending_table;
    bool reading_first = false; ///< the request at hand reads the first table
    std::atomic<bool> loads_first{false};
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
  BackgroundThread thread_;
};

} // namespace tactus::modal
