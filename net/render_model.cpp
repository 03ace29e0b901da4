#include "net/render_model.hpp"

namespace tactus::net {

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
