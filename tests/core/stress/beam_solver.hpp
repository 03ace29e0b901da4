#pragma once

#include "core/stress/reanalysis.hpp"
#include "tests/core/stress/tables.hpp"

#include <memory>
#include <utility>
#include <vector>

namespace tactus::test {

/// Solves the cantilever in closed form; its answer comes after some polls.
class BeamSolver final : public stress::Reanalysis {
public:
  struct Log {
    std::vector<stress::Method> started;
    int polls_needed = 2;
    std::string start_refusal, result_refusal;
    bool damaged = false;
    bool stale_sensitivities = false; ///< unless new ones are asked for
    bool lost = false, loaded = true;
    double reached = 1; ///< of the way that is asked for
    Costs costs{1e-3, 1e-3, 0.1};
    unsigned iterations = 9;
  };
  explicit BeamSolver(std::shared_ptr<Log> log) : log_(std::move(log)) {}
  [[nodiscard]] bool prepare() override { return log_->loaded; }
  [[nodiscard]] Costs costs() const noexcept override { return log_->costs; }
  [[nodiscard]] std::string start(std::span<const double> displacement_m, stress::Method method,
                                  bool sensitivities) override {
    if (!log_->start_refusal.empty())
      return log_->start_refusal;
    log_->started.push_back(method);
    new_sensitivities_ = sensitivities;
    at_ = {log_->reached * displacement_m[0], log_->reached * displacement_m[1]};
    left_ = log_->polls_needed;
    return {};
  }
  [[nodiscard]] std::optional<Result> poll() override {
    if (left_ == 0 || --left_ > 0)
      return {};
    auto base = std::make_shared<stress::StressBase>(Cantilever::solve(at_[0], at_[1]));
    if (log_->damaged)
      base->von_mises.stress.pop_back();
    return Result{log_->result_refusal,
                  std::move(base),
                  log_->started.back(),
                  log_->iterations,
                  0.02,
                  log_->stale_sensitivities && !new_sensitivities_,
                  log_->lost};
  }

private:
  std::shared_ptr<Log> log_;
  std::array<double, 2> at_{};
  int left_ = 0;
  bool new_sensitivities_ = false;
};

} // namespace tactus::test
