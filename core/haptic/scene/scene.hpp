#pragma once

#include "core/haptic/scene/shape.hpp"

#include <cstddef>
#include <cstdint>
#include <variant>
#include <vector>

namespace tactus::haptic {

/// How the surface of a body is rendered.
struct Material {
  double stiffness_n_per_m = 500;
  double damping_n_s_per_m = 0; ///< acts on the approach only, so that the surface never pulls
  double friction = 0;          ///< coefficient of Coulomb friction, mu
};

/// One body of a scene.
struct Body {
  std::uint64_t key = 0; ///< unique; stays the same while the body is edited
  Shape shape{Plane{}};
  Pose pose{};
  Material material{};
  double glide_s = 0; ///< time in which the servo moves the body to a changed pose
};

/// The bodies that can be touched. The host makes a scene, the servo reads it; it is never changed.
struct Scene {
  static constexpr std::size_t kMaxBodies = 72;
  /// Bodies beyond kMaxBodies are ignored. The events of one tick come in this order.
  std::vector<Body> bodies;
  /// Radius of the spherical tool around the handle, m; 0: a point.
  double tool_radius_m = 0;
};

/// The tool has touched a body.
struct HitEvent {
  std::uint64_t key = 0; ///< key of the body
  double time_s = 0;
  Vec3 point{};                ///< m, on the surface
  Vec3 normal{};               ///< outwards
  double approach_m_per_s = 0; ///< speed into the surface, just before the hit
  double slip_m_per_s = 0;     ///< speed along the surface
};
/// The tool still touches the body.
struct ContactEvent {
  std::uint64_t key = 0;
  double time_s = 0;
  double depth_m = 0;
  Vec3 force_n{};
};
/// The tool has left the body.
struct ReleaseEvent {
  std::uint64_t key = 0;
  double time_s = 0;
};
using SceneEvent = std::variant<HitEvent, ContactEvent, ReleaseEvent>;

} // namespace tactus::haptic
