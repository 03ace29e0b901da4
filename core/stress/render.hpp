#pragma once

#include "core/geometry/vec3.hpp"

/// Stress feedback felt as a spring or a damper (Fischer, Vance & Vo's interactive virtual design):
/// a scalar gamma in 0..1, the stress of the part, sets how stiff or how viscous the handle is.
namespace tactus::stress {

/// What gamma 0 and gamma 1 stand for.
struct RenderGains {
  double stiffness_min_n_per_m = 0, stiffness_max_n_per_m = 0;
  double damping_min_n_s_per_m = 0, damping_max_n_s_per_m = 0;
  friend bool operator==(const RenderGains&, const RenderGains&) = default;
};

/// F = -k(gamma) (x - anchor), k = kmin + (kmax - kmin) gamma; gamma has a
/// value for each axis, clamped to 0..1. displacement: x - anchor, m. Returns N.
[[nodiscard]] haptic::Vec3 spring_force(const RenderGains& gains, const haptic::Vec3& gamma,
                                        const haptic::Vec3& displacement) noexcept;

/// F = -b(gamma) v, b = bmin + (bmax - bmin) gamma. velocity: m/s. Returns N.
[[nodiscard]] haptic::Vec3 damper_force(const RenderGains& gains, const haptic::Vec3& gamma,
                                        const haptic::Vec3& velocity) noexcept;

} // namespace tactus::stress
