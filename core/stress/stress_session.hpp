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

/// The newest request of the user.
struct SessionRequest {
  std::uint64_t table = 0; ///< number of the table for which it was made
  FeedbackSettings settings;
  Resolve resolve = Resolve::kAuto;
  int control_point = -1;             ///< the grabbed control point; -1: none
  std::vector<double> displacement_m; ///< [P]
  std::uint64_t picture = 0;          ///< a change of this number requests a picture
};

enum class Solver : std::uint8_t { kNone, kStarting, kReady };

struct SessionResult {
  std::uint64_t table = 0;
  std::uint64_t base_changes = 0; ///< number of new bases and settings; at each, gamma is faded
  Feedback feedback;
  Method method = Method::kTaylor; ///< method by which this value was found
  unsigned iterations = 0;         ///< iterations of the last solve
  double solve_s = 0;              ///< duration of the last solve; 0 before the first
  double update_s = 0;             ///< duration of the last evaluation, measured by the caller
  double error = 0;                ///< estimate of the relative error of the mean stress
  bool outside_trust = false;
  bool solving = false;
  Solver solver = Solver::kNone;
  std::uint64_t picture_number = 0; ///< SessionRequest::picture for which it was drawn
  std::shared_ptr<const Picture> picture;
  friend bool operator==(const SessionResult&, const SessionResult&) = default;
};

/// Stress feedback of a part while the user reshapes it. Every step evaluates the Taylor series
/// (StressModel). When UpdatePolicy requests it, a Reanalysis computes a new solution.
///
/// A solution may come with the sensitivities of an earlier shape. Once the part is at rest these
/// are recomputed as well if resolve is kAuto or kFull. The class has no thread and no clock.
class StressSession {
public:
  /// Initial estimate of the relative error of the mean stress at the trust size: measured on a
  /// cantilever moved by 0.1 of its height. The first solve replaces it by an estimate for the
  /// part.
  static constexpr double kTrustError = 0.01;

  explicit StressSession(std::shared_ptr<const StressTable> table,
                         std::unique_ptr<Reanalysis> reanalysis = {});

  /// Evaluates a request at the time now_s. request.displacement_m has the table's size [P].
  /// Allocates when settings or the base change.
  const SessionResult& step(double now_s, const SessionRequest& request);
  /// Time at which the next step is due without a new request; infinity: never.
  [[nodiscard]] double due_s() const noexcept;
  /// Replaces the solver; null: none.
  void attach(std::unique_ptr<Reanalysis> reanalysis);
  [[nodiscard]] bool can_solve() const noexcept { return reanalysis_ != nullptr; }
  /// Reason for a failed solve since the last call; empty: none.
  [[nodiscard]] std::string take_refusal() { return std::exchange(refusal_, {}); }
  [[nodiscard]] const StressTable& table() const noexcept { return model_.table(); }

private:
  void refuse(const std::string& reason);
  void take_solution();
  [[nodiscard]] std::optional<Method> due(double now_s, const SessionRequest& request);
  void start_solve(double now_s, const SessionRequest& request);

  StressModel model_;
  std::unique_ptr<StressPicture> picture_; ///< made at the first request
  std::unique_ptr<Reanalysis> reanalysis_;
  UpdatePolicy policy_;
  SessionRequest request_;
  SessionResult result_;
  Method base_method_ = Method::kTaylor;
  std::vector<double> factorised_m_; ///< [P] shape of the last full solution
  std::vector<double> requested_m_;  ///< [P] shape of the last solve that was started
  bool stale_sensitivities_ = false; ///< the base's sensitivities belong to an earlier shape
  double error_at_trust_ = kTrustError;
  double last_step_s_ = 0;
  bool selected_ = false, failed_ = false;
  std::string refusal_;
};

} // namespace tactus::stress
