#pragma once

#include "core/stress/reanalysis.hpp"

#include <algorithm>
#include <optional>

/// Decides when the Taylor series of the stress is replaced by a new solution, and by which method.
namespace tactus::stress {

enum class Resolve : std::uint8_t { kAuto, kTaylor, kPcg, kFull };

/// Cost of a solve by conjugate gradients, preconditioned by the factor of the last full solution,
/// and of a solve with a new factor:
///     t_pcg  = n (product + solve),  n = n_0 + n_1 r
///     t_full = factor + solve
/// r: displacement from the factorised shape over the trust size. n: iterations. The line n_0 + n_1
/// r passes through the iterations measured on a cantilever (7 at r = 0.5, 10 at 1, 14 at 2;
/// tolerance 1e-8), and is scaled to the iterations of the part's own solves. Above 15 iterations a
/// new factor is chosen, because it makes later solves cheap.
class CostModel {
public:
  static constexpr double kBaseIterations = 4.5, kIterationsPerRatio = 5; ///< n_0, n_1
  static constexpr double kMaxIterations = 15;

  void set(const Reanalysis::Costs& costs) noexcept { costs_ = costs; }
  /// Scales n to the iterations of a solve by conjugate gradients at the ratio r.
  void learn(const Reanalysis::Result& result, double ratio) noexcept;
  [[nodiscard]] double iterations(double ratio) const noexcept;
  [[nodiscard]] double pcg_s(double ratio) const noexcept;
  [[nodiscard]] double full_s() const noexcept { return costs_.factor_s + costs_.solve_s; }
  [[nodiscard]] Method cheapest(double ratio) const noexcept;

private:
  Reanalysis::Costs costs_{};
  double scale_ = 1; ///< measured iterations over n_0 + n_1 r
};

/// Requests a new solution after 150 ms without motion, or as soon as the displacement from the
/// base exceeds the trust size.
class UpdatePolicy {
public:
  static constexpr double kSettleTime_s = 0.15;
  static constexpr double kMinRatio = 1e-9; ///< trust_ratio below which the shape is that of the
                                            ///< base

  void moved(double now_s) noexcept { moved_s_ = now_s; }
  /// Method of the solve to start now, if any. trust_ratio: displacement from the base over the
  /// trust size; factor_ratio: the same ratio for the displacement from the shape of the last full
  /// solution.
  [[nodiscard]] std::optional<Method> due(double now_s, Resolve resolve, double trust_ratio,
                                          double factor_ratio) const noexcept;
  /// True if the part has not moved for kSettleTime_s.
  [[nodiscard]] bool at_rest(double now_s) const noexcept {
    return now_s - moved_s_ >= kSettleTime_s;
  }
  /// Time at which the part is at rest if it does not move until then.
  [[nodiscard]] double rest_s() const noexcept { return moved_s_ + kSettleTime_s; }
  CostModel costs;

private:
  double moved_s_ = 0;
};

} // namespace tactus::stress
