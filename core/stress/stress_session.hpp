#pragma once

#include "core/stress/stress_model.hpp"
#include "core/stress/stress_picture.hpp"
#include "core/stress/update_policy.hpp"

#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace tactus::stress {

/// What the user wants evaluated; newest wins.
struct SessionRequest {
  std::uint64_t table = 0; ///< number of the table that it was made for
  FeedbackSettings settings;
  Resolve resolve = Resolve::kAuto;
  int control_point = -1;             ///< grabbed; -1: none
  std::vector<double> displacement_m; ///< [P]
  std::uint64_t picture = 0;          ///< another number than before: draw the shape
};

enum class Solver : std::uint8_t { kNone, kStarting, kReady };

struct SessionResult {
  std::uint64_t table = 0;
  std::uint64_t base_changes = 0; ///< counts new bases and settings: gamma is cross-faded
  Feedback feedback;
  Method method = Method::kTaylor; ///< of this value
  unsigned iterations = 0;         ///< of the last solve
  double solve_s = 0;              ///< duration of the last solve; 0 before the first
  double update_s = 0;             ///< duration of the last evaluation, measured by the caller
  double error = 0;                ///< estimate of the relative error of the mean stress
  bool outside_trust = false;
  bool solving = false;
  Solver solver = Solver::kNone;
  std::uint64_t picture_number = 0; ///< of the request for which it was drawn
  std::shared_ptr<const Picture> picture;
  friend bool operator==(const SessionResult&, const SessionResult&) = default;
};

/// A part that is reshaped: Taylor's series at each step, a new solution when the policy asks for
/// one. A solution may come with the sensitivities of an earlier shape: at rest, unless resolve is
/// pcg, which factorises nothing, they are then found anew too. Holds no thread and no clock;
/// solves go through a Reanalysis, if there is one.
class StressSession {
public:
  /// Relative error of the mean stress at the trust size: measured on a cantilever moved by 0.1 of
  /// its height. Solves replace it by the part's own.
  static constexpr double kTrustError = 0.01;

  explicit StressSession(std::shared_ptr<const StressTable> table,
                         std::unique_ptr<Reanalysis> reanalysis = {});

  /// request.displacement_m has the table's size. May allocate when settings or the base change.
  const SessionResult& step(double now_s, const SessionRequest& request);
  /// When the next step is due although nothing is requested: seconds, or infinity.
  [[nodiscard]] double due_in_s(double now_s) const noexcept;
  /// Another solver in the place of the one at hand, or none.
  void attach(std::unique_ptr<Reanalysis> reanalysis);
  [[nodiscard]] bool can_solve() const noexcept { return reanalysis_ != nullptr; }
  /// What a solve failed with since the last call.
  [[nodiscard]] std::string take_refusal() { return std::exchange(refusal_, {}); }
  [[nodiscard]] const StressTable& table() const noexcept { return model_.table(); }

private:
  void refuse(const std::string& reason);
  void take_solution();
  [[nodiscard]] std::optional<Method> due(double now_s, const SessionRequest& request);
  void start_solve(double now_s, const SessionRequest& request);

  StressModel model_;
  std::unique_ptr<StressPicture> picture_; ///< made when it is first asked for
  std::unique_ptr<Reanalysis> reanalysis_;
  UpdatePolicy policy_;
  SessionRequest request_;
  SessionResult result_;
  Method base_method_ = Method::kTaylor;
  std::vector<double> factorised_m_; ///< [P] shape of the last full solution
  std::vector<double> requested_m_;  ///< [P] of the last solve that was started
  bool stale_sensitivities_ = false; ///< the base's belong to an earlier shape
  double error_at_trust_ = kTrustError;
  double last_step_s_ = 0;
  bool selected_ = false, failed_ = false;
  std::string refusal_;
};

} // namespace tactus::stress
