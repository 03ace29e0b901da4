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

/// Reads tables and evaluates stresses in a thread of its own, or in the caller's time. Requests go
/// in and results come out by triple buffers: the newest counts and nobody waits for an evaluation.
class StressWorker {
public:
  struct Loaded {
    std::string refusal; ///< why there is no table, else empty
    std::shared_ptr<const StressTable> table;
    std::uint64_t number = 0; ///< to be named in requests
    bool can_solve = false;   ///< there is a solver for it
  };

  /// Makes the solver of a part; null when there is none for it.
  using SolverFactory = std::function<std::unique_ptr<Reanalysis>(SolverOptions options)>;

  explicit StressWorker(SolverFactory solvers = {}) : solvers_(std::move(solvers)) {}
  ~StressWorker();
  StressWorker(const StressWorker&) = delete;
  StressWorker& operator=(const StressWorker&) = delete;

  /// Without a thread: everything is done when it is asked for. `ready` is called in the thread
  /// when a table, a result or a sentence waits. Returns why no thread starts, else an empty
  /// sentence.
  [[nodiscard]] std::string start(std::function<void()> ready);
  /// Solvers wait for their answers: for a host whose time is not the wall's.
  void wait_for_solvers() noexcept { blocking_solvers_ = true; }
  [[nodiscard]] bool threaded() const noexcept { return thread_.joinable(); }

  /// The last load counts. The old table goes on until the new one is read.
  void load(const std::string& path, std::uint64_t number);
  [[nodiscard]] std::optional<Loaded> take_loaded();
  /// The program that solves, from now on and for the table at hand; empty: where it is looked for.
  void set_program(const std::string& program);
  /// now_s: the caller's time, for the work without a thread.
  void request(const SessionRequest& request, double now_s);
  /// Without a thread: what is due although nothing was requested.
  void poll(double now_s);
  /// And when that is next, in seconds; infinity with a thread, which sees to it itself.
  [[nodiscard]] double due_in_s(double now_s) const noexcept;
  /// Whether a result came since the last call; it is then latest().
  [[nodiscard]] bool read() noexcept { return results_.read(); }
  [[nodiscard]] const SessionResult& latest() const noexcept { return results_.latest(); }
  /// What a solve failed with.
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
  // The worker's alone.
  std::unique_ptr<StressSession> session_;
  std::uint64_t number_ = 0;
  std::string path_, program_;
  // Shared, all short.
  std::mutex mutex_;
  std::condition_variable_any wake_;
  bool wake_requested_ = false;
  std::optional<std::pair<std::string, std::uint64_t>> pending_load_;
  std::optional<std::string> to_program_;
  std::optional<Loaded> loaded_;
  std::string refusal_;
  std::function<void()> ready_;
  std::jthread thread_; // last: it ends before what it uses
};

} // namespace tactus::stress
