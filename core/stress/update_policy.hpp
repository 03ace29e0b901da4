#pragma once

#include "core/stress/reanalysis.hpp"

#include <algorithm>
#include <optional>

/// When Taylor's series of the stress is replaced by a new solution, and how that is found.
namespace tactus::stress {

enum class Resolve : std::uint8_t { kAuto, kTaylor, kPcg, kFull };

/// Conjugate gradients preconditioned by the factor of the last full solution, against a new
/// factor.
///   t_pcg  = n (product + solve),  n = n_0 + n_1 r
///   t_full = factor + solve
/// r: displacement since the factorised shape over the trust size. n_0 and n_1 begin at the line
/// through the iterations measured on a cantilever (7 at r = 0.5, 10 at 1, 14 at 2; tolerance 1e-8)
/// and are scaled to those of the part's own solves. More than 15 iterations: a new factor, which
/// makes the solves after it cheap.
class CostModel {
public:
  static constexpr double kBaseIterations = 4.5, kIterationsPerRatio = 5; ///< n_0, n_1
  static constexpr double kMaxIterations = 15;

  void set(const Reanalysis::Costs& costs) noexcept { costs_ = costs; }
  void learn(const Reanalysis::Result& result, double ratio) noexcept;
  [[nodiscard]] double iterations(double ratio) const noexcept;
  [[nodiscard]] double pcg_s(double ratio) const noexcept;
  [[nodiscard]] double full_s() const noexcept { return costs_.factor_s + costs_.solve_s; }
  [[nodiscard]] Method cheapest(double ratio) const noexcept;

private:
  Reanalysis::Costs costs_{};
  double scale_ = 1; ///< of the line, measured
};

/// Taylor while the part is dragged; a new solution after 150 ms without motion, or as soon as the
/// displacement since the last one leaves the trust size.
class UpdatePolicy {
public:
  static constexpr double kSettleTime_s = 0.15;
  static constexpr double kMinRatio = 1e-9; ///< below it the base is the solution itself

  void moved(double now_s) noexcept { moved_s_ = now_s; }
  /// What to start now. trust_ratio: displacement since the base over the trust size; factor_ratio:
  /// since the shape of the last full solution.
  [[nodiscard]] std::optional<Method> due(double now_s, Resolve resolve, double trust_ratio,
                                          double factor_ratio) const noexcept;
  /// Whether the part has not moved for so long.
  [[nodiscard]] bool at_rest(double now_s) const noexcept {
    return now_s - moved_s_ >= kSettleTime_s;
  }
  /// Time until a part that does not move is at rest.
  [[nodiscard]] double time_to_rest_s(double now_s) const noexcept {
    return std::max(0.0, moved_s_ + kSettleTime_s - now_s);
  }
  CostModel costs;

private:
  double moved_s_ = 0;
};

} // namespace tactus::stress
