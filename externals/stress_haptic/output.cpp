#include "externals/stress_haptic/stress_haptic.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace tactus::stress {

namespace {

constexpr double kStep_ms = 1;             // update interval of gamma and force while they change
constexpr double kInfo_ms = 20;            // shortest time between two reports
constexpr double kFeedback_ms = 10;        // shortest time between two feedback messages
constexpr double kFeedbackRepeat_ms = 250; // a server ends the force 500 ms after the last message
constexpr double kMargin_mm = 1;           // margin of the workspace around the control points

constexpr std::array<std::string_view, 3> kMethods{"taylor", "pcg", "full"};
constexpr std::array<std::string_view, 3> kSolvers{"none", "starting", "ready"};

} // namespace

/// Sends to the outlets from right to left, as Pd's objects do.
void StressHaptic::send(Host& host, bool all) {
  const double now_ms = host.now_ms();
  const Vec3 gamma = gamma_.at(1e-3 * now_ms);
  if (all || (info_due_ && now_ms - info_ms_ >= kInfo_ms)) {
    info_ms_ = now_ms;
    info_due_ = false;
    send_info(host);
  }
  const double since_ms = now_ms - feedback_ms_;
  if (table_ && (all || since_ms >= kFeedbackRepeat_ms ||
                 (since_ms >= kFeedback_ms && sent_feedback_ != gamma)))
    send_feedback(host, gamma);
  if (const Vec3 force_n = force(1e-3 * now_ms);
      all || (has_position_ && sent_force_n_ != force_n)) {
    sent_force_n_ = force_n;
    host.send(kForceOutlet, {force_n.x, force_n.y, force_n.z});
  }
  if (all || (table_ && sent_gamma_ != gamma)) {
    sent_gamma_ = gamma;
    if (is_axis())
      host.send(kGammaOutlet, {gamma.x, gamma.y, gamma.z});
    else
      host.send(kGammaOutlet, {gamma.x});
  }
}

void StressHaptic::send_feedback(Host& host, const Vec3& gamma) {
  feedback_ms_ = host.now_ms();
  sent_feedback_ = gamma;
  const auto sequence = static_cast<double>(++feedback_sequence_);
  if (is_axis())
    host.send(kProtocolOutlet, {"hap", "feedback", sequence, gamma.x, gamma.y, gamma.z});
  else
    host.send(kProtocolOutlet, {"hap", "feedback", sequence, gamma.x});
}

void StressHaptic::send_info(Host& host) {
  if (!table_) {
    host.info({"table", "none"});
    return;
  }
  const Feedback& feedback = result_.feedback;
  // Clamped to the range of single precision.
  const auto clamped = [](double x) { return std::clamp(x, -1e38, 1e38); };
  const auto send_value = [&](std::string_view name, const Vec3& value) {
    if (is_axis())
      host.info({name, clamped(value.x), clamped(value.y), clamped(value.z)});
    else
      host.info({name, clamped(value.x)});
  };
  send_value("gmin", feedback.min);
  send_value("gmax", feedback.max);
  send_value("raw", feedback.raw);
  host.info({"err", result_.error});
  host.info({"method", kMethods[static_cast<std::size_t>(result_.method)]});
  host.info({"solver", kSolvers[static_cast<std::size_t>(result_.solver)]});
  host.info({"iters", static_cast<double>(result_.iterations)});
  host.info({"ms", 1e3 * (result_.method == Method::kTaylor ? result_.update_s : result_.solve_s)});
  host.info({"mean", feedback.mean_pa});
  host.info({"peak", clamped(feedback.peak_pa)});
  host.info({"outside", result_.outside_trust ? 1.0 : 0.0});
}

/// Sets the time of the next output: the next step while gamma or the force changes, else the next
/// repeated feedback message.
void StressHaptic::schedule(Host& host) {
  if (!table_)
    return host.wake_in(0, -1);
  const bool changing = gamma_.moving() || anchor_.moving() || info_due_;
  const double due_ms = changing ? 0
                                 : std::min(feedback_ms_ + kFeedbackRepeat_ms - host.now_ms(),
                                            1e3 * worker_.due_in_s(1e-3 * host.now_ms()));
  host.wake_in(0, std::clamp(due_ms, kStep_ms, kFeedbackRepeat_ms));
}

void StressHaptic::tick(std::size_t, Host& host) {
  worker_.step(1e-3 * host.now_ms());
  collect(host);
}

void StressHaptic::send_points(Host& host) {
  if (!has_table("points", host))
    return;
  const auto& points = table_->control_point_m;
  std::vector<Vec3> low(points), high(points);
  for (const DesignParameter& parameter : table_->parameters) {
    low[parameter.control_point][parameter.axis] += parameter.low_m;
    high[parameter.control_point][parameter.axis] += parameter.high_m;
  }
  Vec3 min = low[0], max = high[0];
  for (std::size_t c = 0; c < points.size(); ++c)
    for (int axis = 0; axis < 3; ++axis) {
      min[axis] = std::min(min[axis], low[c][axis]);
      max[axis] = std::max(max[axis], high[c][axis]);
    }
  const Vec3 margin{kMargin_mm, kMargin_mm, kMargin_mm};
  const Vec3 first = min * kMm_per_m - margin, last = max * kMm_per_m + margin;
  host.send(kProtocolOutlet,
            {"hap", "workspace", first.x, first.y, first.z, last.x, last.y, last.z});
  host.send(kProtocolOutlet, {"hap", "cp", "begin", static_cast<double>(points.size())});
  for (std::size_t c = 0; c < points.size(); ++c) {
    const Vec3 position_mm = (points[c] + displacement_of(c)) * kMm_per_m;
    host.send(kProtocolOutlet, {"hap", "cp", "set", static_cast<double>(c), position_mm.x,
                                position_mm.y, position_mm.z});
  }
  host.send(kProtocolOutlet, {"hap", "cp", "end"});
}

void StressHaptic::dump(Host& host) {
  host.info({"version", "0.1.0"});
  if (table_) {
    host.info({"table", std::string_view(table_->name.empty() ? "part" : table_->name)});
    host.info({"elements", static_cast<double>(table_->elements())});
    host.info({"parameters", static_cast<double>(table_->parameters.size())});
    host.info({"points", static_cast<double>(table_->control_point_m.size())});
    host.info({"trust", kMm_per_m * table_->trust_m});
    host.info({"grabbed", static_cast<double>(request_.control_point)});
  }
  const RenderGains gains = gains_in_force();
  host.info({"gains", gains.stiffness_min_n_per_m, gains.stiffness_max_n_per_m,
             gains.damping_min_n_s_per_m, gains.damping_max_n_s_per_m});
  send_info(host);
}

} // namespace tactus::stress
