#pragma once

#include "core/haptic/servo/mailbox.hpp"
#include "core/stress/stress_session.hpp"
#include "externals/stress_haptic/part_solver.hpp"
#include "files/background_thread.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>

namespace tactus::stress {

/// Reads tables and evaluates stresses, in the background or in the caller's thread. Requests and
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

  explicit StressWorker(SolverFactory solvers = {}) { state_->solvers = std::move(solvers); }

  /// Starts the thread; without it everything is done in the calls. The thread calls `ready` when a
  /// table, a result or an error is available. Returns an empty string, or why no thread starts.
  [[nodiscard]] std::string start(std::function<void()> ready);
  /// Makes solvers block until they answer, for hosts that do not run in real time.
  void wait_for_solvers() noexcept { state_->blocking_solvers = true; }
  [[nodiscard]] bool threaded() const noexcept { return thread_.running(); }

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
  [[nodiscard]] bool read() noexcept { return state_->results.read(); }
  [[nodiscard]] const SessionResult& latest() const noexcept { return state_->results.latest(); }
  /// Reason of a failed solve; empty: none.
  [[nodiscard]] std::string take_refusal();

private:
  struct State : BackgroundState {
    void work() override;
    void execute_program(const std::string& program);
    [[nodiscard]] std::unique_ptr<Reanalysis> solver_for(const StressTable& table) const;
    void execute_load(const std::string& path, std::uint64_t number);
    void step(double now_s);

    SolverFactory solvers;
    bool blocking_solvers = false; // set before there is a thread
    haptic::Mailbox<SessionRequest> requests;
    haptic::Mailbox<SessionResult> results;
    // Used by the worker only.
    std::unique_ptr<StressSession> session;
    std::uint64_t table_number = 0;
    std::string table_path, solver_program;
    // Guarded by `mutex`, which is locked only briefly.
    bool wake_requested = false;
    std::optional<std::pair<std::string, std::uint64_t>> pending_load;
    std::optional<std::string> to_program;
    std::optional<Loaded> loaded;
    std::string refusal;
  };
  std::shared_ptr<State> state_ = std::make_shared<State>();
  BackgroundThread thread_;
};

} // namespace tactus::stress
