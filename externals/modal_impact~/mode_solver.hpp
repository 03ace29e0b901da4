#pragma once

#include "core/modal/table/loaded_table.hpp"
#include "externals/served_program.hpp"

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

namespace tactus::modal {

/// The program modal_fem: beside this module, else in PATH; or the one that is given, a path if it
/// has a slash. Empty when there is none that can be run.
[[nodiscard]] std::string find_modal_fem(const std::string& program);

/// Finds the modes of a table's body at other shapes by `modal_fem serve` as a child process, in a
/// thread of its own or in the caller's time. The child starts at the first request. One that ends,
/// does not answer in time or answers what cannot be is killed, and the solver is lost.
class ModeSolver {
public:
  struct Request {
    std::uint64_t number = 0; ///< of the load, see forget()
    std::string path;         ///< of the body's table
    std::string program;      ///< path or name of modal_fem; empty: where it is looked for
    std::shared_ptr<const LoadedTable> table; ///< from which modes go on; perhaps on a board
    std::vector<double> displacement_m;
  };
  struct Result {
    std::uint64_t number = 0;
    std::string refusal; ///< why there is no new table, else empty
    bool lost = false;   ///< the program has ended: it must not be asked again
    std::shared_ptr<const LoadedTable> before, table; ///< the request's, and what follows it
    double seconds = 0;
    double fraction = 1; ///< of the move that keeps the mesh valid
  };
  struct Limits {
    double start_s = 300; ///< to load the part
    double solve_s = 300; ///< for an answer
  };

  ModeSolver() : ModeSolver(Limits{}) {}
  explicit ModeSolver(const Limits& limits) : limits_(limits) {}
  ~ModeSolver();
  ModeSolver(const ModeSolver&) = delete;
  ModeSolver& operator=(const ModeSolver&) = delete;

  /// Solves in the thread, whose `ready` is called when a result waits; the newest request counts.
  /// Empty, or why there is no thread.
  [[nodiscard]] std::string request(Request request, std::function<void()> ready);
  [[nodiscard]] std::optional<Result> take();
  /// The work itself, in the caller's time: not where request() is used.
  [[nodiscard]] Result solve(const Request& request, const std::stop_token& stop = {});
  /// Ends the child and what is under way: from now on requests have this number.
  void restart(std::uint64_t number);

private:
  void work(const std::stop_token& stop);
  [[nodiscard]] std::string launch(const Request& request);
  /// A message of the child; none when it was lost (the reason in `lost`) or given up.
  [[nodiscard]] std::optional<ServedProgram::Message> await(const Request& request,
                                                            const std::stop_token& stop,
                                                            const ServedProgram::Expects& expects,
                                                            std::string& lost);
  /// Empty, or why the solver is lost.
  [[nodiscard]] std::string exchange(const Request& request, const std::stop_token& stop,
                                     Result& result);

  Limits limits_;
  // The worker's alone.
  std::unique_ptr<ServedProgram> child_;
  std::uint64_t child_number_ = 0;
  bool loaded_ = false;
  // Shared.
  std::atomic<std::uint64_t> number_{0};
  std::mutex mutex_;
  std::condition_variable_any wake_;
  std::optional<Request> waiting_;
  std::optional<Result> done_;
  bool restarting_ = false;
  std::function<void()> ready_;
  std::jthread thread_; // last: it ends before what it uses
};

} // namespace tactus::modal
