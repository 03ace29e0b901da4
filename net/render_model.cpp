#include "net/render_model.hpp"

namespace tactus::net {

using haptic::Vec3;

void LinearGlide::go(const Vec3& target, double now_s) noexcept {
  from_ = at(now_s);
  length_s_ = std::clamp(now_s - since_s_, 0.0, kMax_s);
  since_s_ = now_s;
  target_ = target;
}

Vec3 LinearGlide::at(double now_s) noexcept {
  if (value_ == target_)
    return value_;
  const double share = length_s_ > 0 ? (now_s - since_s_) / length_s_ : 1.0;
  return value_ = share >= 1 ? target_ : from_ + (target_ - from_) * std::max(0.0, share);
}

Vec3 RenderModel::force(const haptic::Tick& tick, const haptic::State& state) noexcept {
  const bool fresh = requests_.read();
  const RenderRequest& request = requests_.latest();
  if (request.mode != RenderMode::kSpring && request.mode != RenderMode::kDamper)
    return {};
  if (request.starts != starts_) {
    starts_ = request.starts;
    gamma_.jump({});
    waiting_ = !request.anchored;
    anchor_.jump(request.anchor);
  }
  if (fresh && !(request.gamma == gamma_.target()))
    gamma_.go(request.gamma, tick.time_s);
  if (fresh && request.anchored && (waiting_ || !(request.anchor == anchor_.target()))) {
    if (waiting_)
      anchor_.jump(request.anchor);
    else
      anchor_.go(request.anchor, tick.time_s);
    waiting_ = false;
  }
  if (waiting_ && (state.flags & haptic::State::kHomed)) {
    waiting_ = false;
    anchor_.jump(state.position);
  }
  const Vec3 gamma = gamma_.at(tick.time_s);
  if (request.mode == RenderMode::kDamper)
    return stress::damper_force(request.gains, gamma, state.velocity);
  return waiting_
             ? Vec3{}
             : stress::spring_force(request.gains, gamma, state.position - anchor_.at(tick.time_s));
}

} // namespace tactus::net
