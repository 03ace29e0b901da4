#pragma once

#include "core/haptic/servo/mailbox.hpp"
#include "core/stress/stress_session.hpp"
#include "externals/stress_haptic/part_solver.hpp"

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <utility>

namespace tactus::stress {

/// Reads tables and evaluates stresses, in a thread of its own or in the caller's. Requests and
/// results pass through triple buffers: only the newest counts, and the caller never waits.
class StressWorker {
public:
  struct Loaded {
    std::string refusal; ///< why the table was not loaded; empty: success
    std::shared_ptr<const StressTable> table;
    std::uint64_t number = 0; ///< SessionRequest::table
    bool can_solve = false;   ///< a solver is attached
  };

  /// Makes the solver of a part; null if there is none.
  using SolverFactory = std::function<std::unique_ptr<Reanalysis>(SolverOptions options)>;

  explicit StressWorker(SolverFactory solvers = {}) : solvers_(std::move(solvers)) {}
  ~StressWorker();
  StressWorker(const StressWorker&) = delete;
  StressWorker& operator=(const StressWorker&) = delete;

  /// Starts the thread; without it everything is done in the calls. The thread calls `ready` when a
  /// table, a result or an error is available. Returns an empty string, or why no thread starts.
  [[nodiscard]] std::string start(std::function<void()> ready);
  /// Makes solvers block until they answer, for hosts that do not run in real time.
  void wait_for_solvers() noexcept { blocking_solvers_ = true; }
  [[nodiscard]] bool threaded() const noexcept { return thread_.joinable(); }

  /// Loads a table; of several loads the last counts. The old table stays in use until then.
  void load(const std::string& path, std::uint64_t number);
  [[nodiscard]] std::optional<Loaded> take_loaded();
  /// Sets the solver program, also for the current table; empty: the default search.
  void set_program(const std::string& program);
  /// now_s: the caller's time, for the work without a thread.
  void request(const SessionRequest& request, double now_s);
  /// Without a thread: does work that is due without a request.
  void poll(double now_s);
  /// Time until such work is due, s; infinity with a thread.
  [[nodiscard]] double due_in_s(double now_s) const noexcept;
  /// True if a result arrived since the last call; it is latest().
  [[nodiscard]] bool read() noexcept { return results_.read(); }
  [[nodiscard]] const SessionResult& latest() const noexcept { return results_.latest(); }
  /// Reason of a failed solve; empty: none.
  [[nodiscard]] std::string take_refusal();

private:
  void work(const std::stop_token& stop);
  void execute_program(const std::string& program);
  [[nodiscard]] std::unique_ptr<Reanalysis> solver_for(const StressTable& table) const;
  void execute_load(const std::string& path, std::uint64_t number);
  void step(double now_s);

  SolverFactory solvers_;
  bool blocking_solvers_ = false; // set before there is a thread
  haptic::Mailbox<SessionRequest> requests_;
  haptic::Mailbox<SessionResult> results_;
  // Used by the worker only.
  std::unique_ptr<StressSession> session_;
  std::uint64_t number_ = 0;
  std::string path_, program_;
  // Shared; locked only briefly.
  std::mutex mutex_;
  std::condition_variable wake_;
  bool wake_requested_ = false;
  std::optional<std::pair<std::string, std::uint64_t>> pending_load_;
  std::optional<std::string> to_program_;
  std::optional<Loaded> loaded_;
  std::string refusal_;
  std::function<void()> ready_;
  std::jthread thread_; // last: it ends before what it uses
};

} // namespace tactus::stress
