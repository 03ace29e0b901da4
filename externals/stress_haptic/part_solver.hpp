#pragma once

#include "core/serve/part_stress.hpp"
#include "core/stress/reanalysis.hpp"
#include "externals/served_program.hpp"

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace tactus::stress {

using serve::ServeHeader;
using serve::ServeKind;
using serve::ServeMethod;

/// The table that a solver is made for, and how to run it.
struct SolverOptions {
  const StressTable& table; ///< must outlive the solver
  std::string path;         ///< path of the table
  std::string program;      ///< path or name of part_stress; if empty, searched for
  bool wait = false;        ///< blocks until every answer, so that renders are repeatable
};

/// Path of the program part_stress. `program`, if given, is a path if it has a slash, else a name
/// that is searched for in PATH. Without it the program is searched for beside this module and in
/// PATH. Empty if no such program can be run.
[[nodiscard]] std::string find_part_stress(const std::string& program);

/// Solves a table's part by `part_stress serve`, run as a child process. Once the child has loaded
/// the part, its solution at the table's own shape is compared with the table. A child that ends,
/// does not answer in time or sends an invalid answer is killed, and the solver is lost.
class PartSolver final : public Reanalysis {
public:
  static constexpr double kTolerance = 1e-8; ///< ||f - K u|| / ||f|| of PCG
  static constexpr double kSameStress =
      1e-3; ///< largest difference from the table / largest stress
  struct Limits {
    double start_s = 300; ///< longest time to load the part
    double solve_s = 30;  ///< longest time for an answer; large costs extend it
  };

  explicit PartSolver(SolverOptions options) : PartSolver(std::move(options), Limits{}) {}
  PartSolver(SolverOptions options, const Limits& limits);

  [[nodiscard]] bool prepare() override;
  /// Costs measured by the child. They are 0 with `wait`, because the choice of a method must then
  /// depend on the iterations only and not on the clock.
  [[nodiscard]] Costs costs() const noexcept override { return options_.wait ? Costs{} : costs_; }
  [[nodiscard]] std::string start(std::span<const double> displacement_m, Method method,
                                  bool sensitivities) override;
  [[nodiscard]] std::optional<Result> poll() override;

private:
  enum class State : std::uint8_t { kNone, kLoading, kChecking, kReady, kSolving, kLost };

  void launch();
  void advance();
  void take(ServeKind kind, std::span<const std::byte> payload);
  void take_ready(std::span<const std::byte> payload);
  void take_answer(std::span<const std::byte> payload);
  [[nodiscard]] bool is_initial_base(const StressBase& base) const;
  void send_request(std::span<const double> displacement_m, ServeMethod method, std::uint32_t flags,
                    double limit_s);
  void mark_lost(const std::string& reason);
  [[nodiscard]] std::uint64_t answer_bytes() const noexcept;

  SolverOptions options_;
  Limits limits_;
  Costs costs_;
  std::unique_ptr<ServedProgram> child_;
  State state_ = State::kNone;
  bool sensitivities_ = false;               ///< whether sensitivities are requested
  std::shared_ptr<const StressBase> latest_; ///< from the newest answer; null for the table's own
  std::optional<Result> result_;
};

} // namespace tactus::stress
