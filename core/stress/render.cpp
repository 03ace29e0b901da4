#include "core/stress/render.hpp"

namespace tactus::stress {
namespace {

/// -(low + (high - low) gamma) motion on each axis.
Vec3 opposing(double low, double high, const Vec3& gamma, const Vec3& motion) noexcept {
  Vec3 force;
  for (int axis = 0; axis < 3; ++axis)
    force[axis] = -(low + (high - low) * std::clamp(gamma[axis], 0.0, 1.0)) * motion[axis];
  return force;
}

} // namespace

Vec3 spring_force(const RenderGains& gains, const Vec3& gamma, const Vec3& displacement) noexcept {
  return opposing(gains.stiffness_min_n_per_m, gains.stiffness_max_n_per_m, gamma, displacement);
}

Vec3 damper_force(const RenderGains& gains, const Vec3& gamma, const Vec3& velocity) noexcept {
  return opposing(gains.damping_min_n_s_per_m, gains.damping_max_n_s_per_m, gamma, velocity);
}

} // namespace tactus::stress
