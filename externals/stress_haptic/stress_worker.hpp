#pragma once

#include "core/stress/stress_session.hpp"
#include "externals/stress_haptic/part_solver.hpp"
#include "files/worker.hpp"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

namespace tactus::stress {

/// Reads tables and evaluates stresses. If a table cannot be read, the previous table stays in use.
class StressJob {
public:
  /// SessionRequest::table is the number of the table in use. A request for another table is not
  /// evaluated.
  struct Request : SessionRequest {
    std::string path, name;       ///< path of the table, and its name as the user wrote it
    std::uint64_t load = 0;       ///< number of the request to load, 0 for none
    std::string program;          ///< the solver's; if empty, searched for
    std::uint64_t set_solver = 0; ///< a different number restarts the solver
    bool wait = false;            ///< solvers wait if the host does not run in real time
  };
  struct Answer {
    std::shared_ptr<const StressTable> table;
    std::uint64_t load = 0;
    bool can_solve = false; ///< a solver is attached
    SessionResult result;   ///< empty until a table is loaded
  };
  static constexpr const char* kOutOfMemory =
      "not enough memory for the stress; the last value is kept";
  /// Makes the solver of a part; null if there is none.
  using SolverFactory = std::function<std::unique_ptr<Reanalysis>(SolverOptions options)>;

  explicit StressJob(SolverFactory solvers = {}) : solvers_(std::move(solvers)) {}
  double work(const Request& request, Turn<Answer>& turn);

private:
  [[nodiscard]] std::unique_ptr<Reanalysis> solver_for(const StressTable& table,
                                                       const Request& request) const;
  void load(const Request& request, Turn<Answer>& turn);

  SolverFactory solvers_;
  std::unique_ptr<StressSession> session_;
  std::string path_;
  Answer answer_;
  std::uint64_t load_seen_ = 0, set_solver_seen_ = 0;
};

using StressWorker = Worker<StressJob>;

} // namespace tactus::stress
