#pragma once

#include "core/modal/table/loaded_table.hpp"
#include "externals/served_program.hpp"
#include "files/worker.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tactus::modal {

/// The path of modal_fem: beside this module, else in PATH. `program`, if given, replaces it and is
/// a path if it contains a slash. Empty if no such program can be run.
[[nodiscard]] std::string find_modal_fem(const std::string& program);

/// Computes the modes of a body at other shapes with the child process `modal_fem serve`. The child
/// starts at the first request. If it ends, does not answer in time or sends an invalid answer, it
/// is killed and the solver is lost.
class ModeJob {
public:
  struct Request {
    std::uint64_t number = 0;                 ///< number of the load; another number ends the child
    std::string path;                         ///< path of the body's table
    std::string program;                      ///< path or name of modal_fem; if empty, searched for
    std::shared_ptr<const LoadedTable> table; ///< the body's present table; null if there is
                                              ///< nothing to solve
    std::vector<double> displacement_m;
  };
  struct Answer {
    std::uint64_t number = 0;
    std::string refusal; ///< reason why there is no new table, else empty
    bool lost = false;   ///< the program has ended; no further requests
    std::shared_ptr<const LoadedTable> before, table; ///< table of the request, and the new table
    double seconds = 0;
    double fraction = 1; ///< fraction of the move up to which the mesh stays valid
  };
  struct Limits {
    double start_s = 300; ///< longest time to load the part
    double solve_s = 300; ///< longest time to answer a request
  };
  static constexpr const char* kOutOfMemory = "resolve: not enough memory";

  ModeJob() : ModeJob(Limits{}) {}
  explicit ModeJob(const Limits& limits) : limits_(limits) {}
  double work(const Request& request, Turn<Answer>& turn);

private:
  [[nodiscard]] std::string launch(const Request& request);
  /// Waits for a message of the child. nullopt if the child was lost (reason in `lost`) or the
  /// request was cancelled.
  [[nodiscard]] std::optional<ServedProgram::Message>
  await(const Turn<Answer>& turn, const ServedProgram::Expects& expects, std::string& lost);
  /// Waits until a started child has loaded the body. False with the reason in `lost`, which is
  /// empty if the request was cancelled.
  [[nodiscard]] bool await_ready(const Request& request, const Turn<Answer>& turn,
                                 std::string& lost);
  /// Sends the request and reads the answer. Returns an empty text, or the reason why the solver is
  /// lost.
  [[nodiscard]] std::string exchange(const Request& request, const Turn<Answer>& turn,
                                     Answer& answer);

  Limits limits_;
  std::unique_ptr<ServedProgram> child_;
  std::uint64_t child_number_ = 0;
  bool loaded_ = false;
};

using ModeSolver = Worker<ModeJob>;

} // namespace tactus::modal
