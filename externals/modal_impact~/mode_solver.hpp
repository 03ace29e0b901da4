#pragma once

#include "core/modal/table/loaded_table.hpp"
#include "externals/served_program.hpp"
#include "files/background_thread.hpp"

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tactus::modal {

/// The path of modal_fem: beside this module, else in PATH; or the given program, a path if it has
/// a slash. Empty if there is none that can be run.
[[nodiscard]] std::string find_modal_fem(const std::string& program);

/// Computes the modes of a body at other shapes with the child process `modal_fem serve`, in
/// the background or in the caller's thread. The child starts at the first request. If it ends,
/// does not answer in time or sends an invalid answer, it is killed and the solver is lost.
class ModeSolver {
public:
  struct Request {
    std::uint64_t number = 0;                 ///< of the load, see restart()
    std::string path;                         ///< of the body's table
    std::string program;                      ///< path or name of modal_fem; empty: searched for
    std::shared_ptr<const LoadedTable> table; ///< the present table, perhaps with a board
    std::vector<double> displacement_m;
  };
  struct Result {
    std::uint64_t number = 0;
    std::string refusal; ///< why there is no new table, else empty
    bool lost = false;   ///< the program has ended; no further requests
    std::shared_ptr<const LoadedTable> before, table; ///< of the request, and the new one
    double seconds = 0;
    double fraction = 1; ///< of the move up to which the mesh stays valid
  };
  struct Limits {
    double start_s = 300; ///< to load the part
    double solve_s = 300; ///< to answer a request
  };

  ModeSolver() : ModeSolver(Limits{}) {}
  explicit ModeSolver(const Limits& limits) { state_->limits = limits; }

  /// Solves in the thread; of waiting requests the newest counts. `ready` is called there when a
  /// result waits. Returns empty, or why no thread could be started.
  [[nodiscard]] std::string request(Request request, std::function<void()> ready);
  [[nodiscard]] std::optional<Result> take();
  /// Solves in the caller's thread; not to be mixed with request().
  [[nodiscard]] Result solve(const Request& request) { return state_->solve(request); }
  /// Ends the child and the present request; from now on requests have this number.
  void restart(std::uint64_t number);

private:
  struct State : BackgroundState {
    void work() override;
    [[nodiscard]] Result solve(const Request& request);
    [[nodiscard]] std::string launch(const Request& request);
    /// Waits for a message of the child. None if the child was lost (reason in `lost`) or the
    /// request was given up.
    [[nodiscard]] std::optional<ServedProgram::Message>
    await(const Request& request, const ServedProgram::Expects& expects, std::string& lost);
    /// Waits until a started child has loaded the body. False with the reason in `lost`, which is
    /// empty if the request was given up.
    [[nodiscard]] bool await_ready(const Request& request, std::string& lost);
    /// Sends the request and reads the answer. Empty, or why the solver is lost.
    [[nodiscard]] std::string exchange(const Request& request, Result& result);

    Limits limits;
    // Used by the worker only.
    std::unique_ptr<ServedProgram> child;
    std::uint64_t child_number = 0;
    bool loaded = false;
    // Shared; all but `number` guarded by `mutex`.
    std::atomic<std::uint64_t> number{0};
    std::optional<Request> waiting;
    std::optional<Result> done;
    bool restarting = false;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
  BackgroundThread thread_;
};

} // namespace tactus::modal
