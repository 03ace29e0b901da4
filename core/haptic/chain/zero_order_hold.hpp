#pragma once

namespace tactus::haptic {

/// One step of a mass on a spring and a damper, M x'' = u - K x - B v, over a time T during which
/// the force u is held. Exact, by the matrix exponential:
///   x <- xx x + xv v + xu u,   v <- vx x + vv v + vu u        SI
struct MassSpringDamperStep {
  double xx = 1, xv = 0, xu = 0;
  double vx = 0, vv = 1, vu = 0;

  /// mass_kg > 0, stiffness and damping >= 0, period_s > 0.
  [[nodiscard]] static MassSpringDamperStep of(double mass_kg, double stiffness_n_per_m,
                                               double damping_n_s_per_m, double period_s) noexcept;

  void advance(double& position, double& velocity, double force) const noexcept {
    const double x = xx * position + xv * velocity + xu * force;
    velocity = vx * position + vv * velocity + vu * force;
    position = x;
  }
};

} // namespace tactus::haptic
