#pragma once

#include "core/haptic/scene/shape.hpp"

#include <cstddef>
#include <cstdint>
#include <vector>

namespace tactus::haptic {

struct Material {
  double stiffness_n_per_m = 500;
  double damping_n_s_per_m = 0; ///< of the approach alone, so that nothing sticks
  double friction = 0;          ///< Coulomb's: the largest tangential over normal force
};

struct Body {
  std::uint64_t key = 0; ///< a body keeps it while it is edited; never used twice
  Shape shape{Plane{}};
  Pose pose{};
  Material material{};
  double glide_s = 0; ///< a pose that differs from the servo's is reached after this time
};

/// What can be touched, as the host wants it. Made by the host, read by the servo, never changed.
struct Scene {
  static constexpr std::size_t kMaxBodies = 72;
  /// What lies beyond kMaxBodies is not felt. The events of one tick come in this order.
  std::vector<Body> bodies;
  /// Of the sphere that touches, its centre at the handle; 0: a point. m
  double tool_radius_m = 0;
};

/// What happened between the handle and a body, at the time of a tick.
struct ContactEvent {
  enum class Kind { kHit, kContact, kRelease };
  Kind kind = Kind::kHit;
  std::uint64_t key = 0;
  double time_s = 0;
  Vec3 point{};                ///< m, on the surface
  Vec3 normal{};               ///< outwards
  double approach_m_per_s = 0; ///< of a hit: speed into the surface just before
  double slip_m_per_s = 0;     ///< of a hit: speed along the surface
  double depth_m = 0;          ///< of a contact
  Vec3 force_n{};              ///< of a contact
};

} // namespace tactus::haptic
