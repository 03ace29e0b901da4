#pragma once

#include "core/geometry/vec3.hpp"

/// Haptic rendering of stress feedback as a spring or a damper (Fischer, Vance & Vo 2009): gamma in
/// 0..1, a measure of the part's stress, sets the stiffness or the damping of the handle.
namespace tactus::stress {

/// Stiffness and damping at gamma = 0 (min) and gamma = 1 (max).
struct RenderGains {
  double stiffness_min_n_per_m = 0, stiffness_max_n_per_m = 0;
  double damping_min_n_s_per_m = 0, damping_max_n_s_per_m = 0;
  friend bool operator==(const RenderGains&, const RenderGains&) = default;
};

/// Spring force, N: F = -k (x - anchor), k = kmin + (kmax - kmin) gamma per axis. gamma is clamped
/// to 0..1. displacement: x - anchor, m.
[[nodiscard]] Vec3 spring_force(const RenderGains& gains, const Vec3& gamma,
                                const Vec3& displacement) noexcept;

/// Damper force, N: F = -b v, b = bmin + (bmax - bmin) gamma per axis. velocity: m/s.
[[nodiscard]] Vec3 damper_force(const RenderGains& gains, const Vec3& gamma,
                                const Vec3& velocity) noexcept;

} // namespace tactus::stress
