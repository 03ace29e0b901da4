#include "core/stress/stress_session.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace tactus::stress {
namespace {

// Poll intervals: of a solve, of a solver that loads its part, and of an idle solver.
constexpr double kPoll_s = 0.002, kStartingPoll_s = 0.02, kIdlePoll_s = 0.5;
constexpr double kReached = 1e-6; // share of the trust size: two shapes closer than this are equal

} // namespace

StressSession::StressSession(std::shared_ptr<const StressTable> table,
                             std::unique_ptr<Reanalysis> reanalysis)
    : model_(std::move(table)) {
  request_.displacement_m.assign(model_.table().parameters.size(), 0);
  attach(std::move(reanalysis));
}

void StressSession::attach(std::unique_ptr<Reanalysis> reanalysis) {
  reanalysis_ = std::move(reanalysis);
  factorised_m_.assign(model_.table().parameters.size(), 0);
  result_.solving = failed_ = false;
  result_.solver = reanalysis_ ? Solver::kStarting : Solver::kNone;
}

void StressSession::refuse(const std::string& reason) {
  refusal_ = "resolve: " + reason + "; the last stress is kept";
  failed_ = true;
}

/// Sets the new base, and measures the error of the series at its shape.
void StressSession::take_solution() {
  auto solved = reanalysis_->poll();
  if (!solved)
    return;
  result_.solving = false;
  if (solved->lost) {
    refusal_ =
        "resolve: " + solved->refusal + "; the Taylor series continues until 'load' or 'solver'";
    return attach(nullptr);
  }
  if (solved->refusal.empty())
    solved->refusal = solved->base ? check_base(model_.table(), *solved->base)
                                   : "the solver returned no solution";
  if (!solved->refusal.empty())
    return refuse(solved->refusal);
  const Feedback series = model_.update(solved->base->displacement_m);
  const double factor_ratio =
      model_.distance_m(solved->base->displacement_m, factorised_m_) / model_.table().trust_m;
  policy_.costs.learn(*solved, factor_ratio);
  if (solved->method == Method::kFull)
    factorised_m_ = solved->base->displacement_m;
  base_method_ = solved->method;
  stale_sensitivities_ = solved->stale_sensitivities;
  result_.iterations = solved->iterations;
  result_.solve_s = solved->seconds;
  const auto solution = solved->base;
  model_.rebase(solution);
  const double mean = model_.update(solution->displacement_m).mean_pa;
  if (series.trust_ratio > kReached && mean > 0)
    error_at_trust_ =
        std::abs(series.mean_pa / mean - 1) / (series.trust_ratio * series.trust_ratio);
  ++result_.base_changes;
  const double trust_m = model_.table().trust_m;
  if (const double distance = model_.distance_m(requested_m_, solution->displacement_m);
      distance > kReached * trust_m) {
    refusal_ = "resolve: elements would be inverted at this shape: the stress is solved " +
               number_text(1e3 * distance) +
               " mm short of it, and the Taylor series continues from there";
    failed_ = true;
  }
}

/// The method of a solve that is due, if any. If the shape is that of the base, a solve is due only
/// for the sensitivities.
std::optional<Method> StressSession::due(double now_s, const SessionRequest& request) {
  const double ratio = result_.feedback.trust_ratio;
  if (ratio <= UpdatePolicy::kMinRatio)
    return stale_sensitivities_ && policy_.at_rest(now_s) &&
                   (request.resolve == Resolve::kAuto || request.resolve == Resolve::kFull)
               ? std::optional(Method::kFull)
               : std::nullopt;
  const double factor_ratio =
      model_.distance_m(request.displacement_m, factorised_m_) / model_.table().trust_m;
  return policy_.due(now_s, request.resolve, ratio, factor_ratio);
}

void StressSession::start_solve(double now_s, const SessionRequest& request) {
  if (!reanalysis_ || result_.solving || failed_ || request.resolve == Resolve::kTaylor)
    return;
  if (!reanalysis_->prepare())
    return;
  if (result_.solver == Solver::kStarting) {
    result_.solver = Solver::kReady;
    policy_.costs.set(reanalysis_->costs());
  }
  const auto method = due(now_s, request);
  if (!method)
    return;
  const bool sensitivities = result_.feedback.trust_ratio <= UpdatePolicy::kMinRatio;
  requested_m_ = request.displacement_m;
  if (const std::string refusal =
          reanalysis_->start(request.displacement_m, *method, sensitivities);
      !refusal.empty())
    return refuse(refusal);
  result_.solving = true;
}

const SessionResult& StressSession::step(double now_s, const SessionRequest& request) {
  if (reanalysis_)
    take_solution();
  if (!selected_ || request.settings != request_.settings ||
      request.control_point != request_.control_point) {
    model_.select(request.settings,
                  request.control_point < 0
                      ? std::nullopt
                      : std::optional(static_cast<std::size_t>(request.control_point)));
    ++result_.base_changes;
    selected_ = true;
  }
  if (request.displacement_m != request_.displacement_m) {
    policy_.moved(now_s);
    failed_ = false;
  }
  request_ = request;
  last_step_s_ = now_s;
  result_.table = request.table;
  result_.feedback = model_.update(request.displacement_m);
  const double ratio = result_.feedback.trust_ratio;
  result_.method = ratio > UpdatePolicy::kMinRatio ? Method::kTaylor : base_method_;
  result_.error = error_at_trust_ * ratio * ratio;
  result_.outside_trust = ratio > 1;
  if (request.picture != result_.picture_number) {
    if (!picture_)
      picture_ = std::make_unique<StressPicture>(model_.table());
    result_.picture = picture_->draw(model_, request.displacement_m);
    result_.picture_number = request.picture;
  }
  start_solve(now_s, request);
  return result_;
}

double StressSession::due_s() const noexcept {
  if (!reanalysis_)
    return std::numeric_limits<double>::infinity();
  if (result_.solving)
    return last_step_s_ + kPoll_s;
  if (failed_ || request_.resolve == Resolve::kTaylor)
    return last_step_s_ + kIdlePoll_s;
  if (result_.solver == Solver::kStarting)
    return last_step_s_ + kStartingPoll_s;
  const bool moved = result_.feedback.trust_ratio > UpdatePolicy::kMinRatio;
  const bool refreshes = stale_sensitivities_ && request_.resolve != Resolve::kPcg;
  const double idle_s = last_step_s_ + kIdlePoll_s;
  return moved || refreshes ? std::min(idle_s, policy_.rest_s()) : idle_s;
}

} // namespace tactus::stress
