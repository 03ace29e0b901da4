#include "core/stress/stress_session.hpp"

#include <cmath>
#include <limits>
#include <utility>

namespace tactus::stress {
namespace {

constexpr double kPoll_s = 0.002; // between looks for a solution

} // namespace

StressSession::StressSession(std::shared_ptr<const StressTable> table,
                             std::unique_ptr<Reanalysis> reanalysis)
    : model_(std::move(table)), reanalysis_(std::move(reanalysis)) {
  factorised_m_.assign(model_.table().parameters.size(), 0);
  request_.displacement_m = factorised_m_;
  if (reanalysis_)
    policy_.costs.set(reanalysis_->costs());
}

/// The error of the series is measured where the new solution stands.
void StressSession::take_solution() {
  auto solved = reanalysis_->poll();
  if (!solved)
    return;
  result_.solving = false;
  if (solved->refusal.empty() && solved->base)
    solved->refusal = check_base(model_.table(), *solved->base);
  if (!solved->refusal.empty() || !solved->base) {
    refusal_ = "resolve: " + (solved->refusal.empty() ? "no solution came" : solved->refusal) +
               "; the last stress stays";
    failed_ = true;
    return;
  }
  const Feedback series = model_.update(solved->base->displacement_m);
  const double factor_ratio =
      model_.distance_m(solved->base->displacement_m, factorised_m_) / model_.table().trust_m;
  policy_.costs.learn(*solved, factor_ratio);
  if (solved->method == Method::kFull)
    factorised_m_ = solved->base->displacement_m;
  base_method_ = solved->method;
  result_.iterations = solved->iterations;
  result_.solve_s = solved->seconds;
  const auto solution = solved->base;
  model_.rebase(solution);
  const double mean = model_.update(solution->displacement_m).mean_pa;
  if (series.trust_ratio > 0 && mean > 0)
    error_at_trust_ =
        std::abs(series.mean_pa / mean - 1) / (series.trust_ratio * series.trust_ratio);
  ++result_.swaps;
}

void StressSession::start_solve(double now_s, const SessionRequest& request) {
  if (!reanalysis_ || result_.solving || failed_)
    return;
  const double factor_ratio =
      model_.distance_m(request.displacement_m, factorised_m_) / model_.table().trust_m;
  const auto method =
      policy_.due(now_s, request.resolve, result_.feedback.trust_ratio, factor_ratio);
  if (!method)
    return;
  refusal_ = reanalysis_->start(request.displacement_m, *method);
  failed_ = !refusal_.empty();
  if (failed_)
    refusal_ = "resolve: " + refusal_ + "; the last stress stays";
  result_.solving = !failed_;
}

const SessionResult& StressSession::step(double now_s, const SessionRequest& request) {
  if (reanalysis_ && result_.solving)
    take_solution();
  if (!selected_ || request.settings != request_.settings ||
      request.control_point != request_.control_point) {
    model_.select(request.settings,
                  request.control_point < 0
                      ? std::nullopt
                      : std::optional(static_cast<std::size_t>(request.control_point)));
    ++result_.swaps;
    selected_ = true;
  }
  if (request.displacement_m != request_.displacement_m) {
    policy_.moved(now_s);
    failed_ = false;
  }
  request_ = request;
  stepped_s_ = now_s;
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

double StressSession::due_in_s(double now_s) const noexcept {
  if (result_.solving)
    return std::max(0.0, stepped_s_ + kPoll_s - now_s);
  if (!reanalysis_ || failed_ || request_.resolve == Resolve::kTaylor ||
      !(result_.feedback.trust_ratio > UpdatePolicy::kMinRatio))
    return std::numeric_limits<double>::infinity();
  return policy_.rest_in_s(now_s);
}

} // namespace tactus::stress
