#pragma once

namespace tactus::haptic {

/// Ratings of the motors and the period of the ticks.
struct ThermalSettings {
  double period_s = 1e-3;  ///< how long the force was held
  double peak_n = 8;       ///< the force limit while the motors are cool
  double continuous_n = 0; ///< continuous rating (root mean square); 0: not known
};

/// I^2 t limit: keeps the motors of a device below their continuous rating. The losses are
/// proportional to the squared force; the temperature follows with one time constant,
///   h' = (|F|^2 - h) / tau,   tau = 30 s,   [h] = N^2,
/// so that h tends to the mean square of the force. The limit C of the force falls with h:
///   C^2 = peak^2 for h <= continuous^2 / 2, from there linear in h to (0.9 continuous)^2 at
///   h = continuous^2.
/// C is continuous in time and falls below the rating before h reaches it, so that a constant
/// request settles below `continuous` without a step. Source: thermal model of a motor with one
/// time constant, e.g. IEC 60034-11. tau is our choice, of the order of a small motor winding's
/// time constant.
///
/// If the device itself reports warm motors, the limit goes to half of `continuous` over
/// kWarmRamp_s (to half of the peak if `continuous` is not known). When the report ends, the limit
/// goes back over kCoolRamp_s.
class ThermalLimit {
public:
  ThermalLimit() = default;
  /// Starts with the given h, N^2; NaN counts as cold.
  explicit ThermalLimit(double heat_n2) noexcept : heat_n2_(heat_n2 > 0 ? heat_n2 : 0) {}

  static constexpr double kTimeConstant_s = 30;
  static constexpr double kWarmRamp_s = 1, kCoolRamp_s = 10;

  /// Updates the heat after a tick with this force, N; reported_warm: the device reports warm
  /// motors.
  void advance(const ThermalSettings& settings, double force_n, bool reported_warm) noexcept;
  /// The force limit now, N; never above peak_n.
  [[nodiscard]] double ceiling_n(const ThermalSettings& settings) const noexcept;
  /// Whether to report the lowered limit to the user: true when it falls below 0.95 of the peak,
  /// false again when it is the peak and h < 0.4 continuous^2 (hysteresis).
  [[nodiscard]] bool derating() const noexcept { return derating_; }
  /// The limit, N, at which a constant request settles: the C with C^2 = h, or the limit for warm
  /// motors while the device reports them.
  [[nodiscard]] double steady_limit_n(const ThermalSettings& settings) const noexcept;
  /// h, N^2
  [[nodiscard]] double heat_n2() const noexcept { return heat_n2_; }

private:
  double heat_n2_ = 0;
  double warm_ = 0; ///< weight of the limit for reported warm motors, 0..1
  bool reported_ = false, derating_ = false;
};

} // namespace tactus::haptic
