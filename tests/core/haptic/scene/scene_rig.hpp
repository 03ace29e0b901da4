#pragma once

#include "core/dsp/random.hpp"
#include "core/haptic/scene/scene_model.hpp"

#include <memory>
#include <vector>

/// A scene that is touched tick by tick, in millimetres.
namespace tactus::haptic::test {

/// Anywhere in the cube of that half side about the origin.
inline Vec3 random_point(Random& random, double reach) {
  const auto one = [&] { return reach * (2 * random.uniform() - 1); };
  const double x = one(), y = one();
  return {x, y, one()};
}

inline Pose random_pose(Random& random, double reach) {
  const auto one = [&] { return random.uniform() - 0.5; };
  const Vec3 at = random_point(random, reach);
  const double w = one(), x = one(), y = one();
  return {at, Rotation::of(w, x, y, one())};
}

class SceneRig {
public:
  Scene scene;
  SceneModel model;

  explicit SceneRig(std::int64_t work_per_tick = SceneModel::kWorkPerTick) : model(work_per_tick) {}

  Body& add(Shape shape, Pose pose = {}, Material material = {}) {
    Body body;
    body.key = ++keys_;
    body.shape = std::move(shape);
    body.pose = pose;
    body.material = material;
    scene.bodies.push_back(body);
    publish();
    return scene.bodies.back();
  }
  /// The sphere about the handle that touches, and not its centre.
  SceneRig& with_tool(double radius_mm) {
    scene.tool_radius_m = radius_mm * 1e-3;
    publish();
    return *this;
  }
  /// A body begins a straight motion to there.
  void glide(std::size_t body, const Vec3& to_m, double seconds) {
    scene.bodies[body].pose.position = to_m;
    scene.bodies[body].glide_s = seconds;
    publish();
  }
  void publish() { model.publish(std::make_unique<const Scene>(scene)); }

  /// One tick with the handle there; the velocity is the motion's since the last one.
  Vec3 touch(const Vec3& mm) {
    State state;
    state.position = mm * 1e-3;
    if (ticks > 0)
      state.velocity = (state.position - last_) * 1e3;
    last_ = state.position;
    const Vec3 force = model.force({ticks, static_cast<double>(ticks) * 1e-3, 1e-3}, state);
    ++ticks;
    SceneEvent event;
    while (model.events().pop(event))
      events.push_back(event);
    return force;
  }
  /// Held there for so many ticks; the last force.
  Vec3 rest(int count, const Vec3& mm) {
    Vec3 force;
    for (; count > 0; --count)
      force = touch(mm);
    return force;
  }
  /// Straight from one place to another in steps of at most that length; the last force.
  Vec3 stroke(const Vec3& from_mm, const Vec3& to_mm, double step_mm = 0.25) {
    const double length = norm(to_mm - from_mm);
    const int count = std::max(1, static_cast<int>(std::ceil(length / step_mm)));
    Vec3 force;
    for (int i = 0; i <= count; ++i)
      force = touch(from_mm + (to_mm - from_mm) * (static_cast<double>(i) / count));
    return force;
  }
  template <class T> std::size_t count() const {
    std::size_t n = 0;
    for (const SceneEvent& event : events)
      n += std::holds_alternative<T>(event);
    return n;
  }
  Vec3 proxy_mm() const { return model.proxy() * 1e3; }
  const Vec3& last_m() const { return last_; }

  std::vector<SceneEvent> events;
  std::uint64_t ticks = 0;

private:
  Vec3 last_{};
  std::uint64_t keys_ = 0;
};

} // namespace tactus::haptic::test
