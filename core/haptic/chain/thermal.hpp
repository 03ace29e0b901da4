#pragma once

namespace tactus::haptic {

/// What a device says of its motors' heat.
struct ThermalSettings {
  double period_s = 1e-3;  ///< how long the force was held
  double peak_n = 8;       ///< the force limit while the motors are cool
  double continuous_n = 0; ///< the root mean square that they bear for ever; 0: not known
};

/// Keeps motors below their continuous rating, I^2 t: their heat is proportional to the squared
/// force and leaks with one time constant,
///   h' = (|F|^2 - h) / tau,   tau = 30 s,   [h] = N^2
/// so that h tends to the mean square of the force. The ceiling C of the force falls with h:
///   C^2 = peak^2 up to h = continuous^2 / 2, then linearly to (0.9 continuous)^2 at continuous^2.
/// C is continuous in time and below the rating before h reaches it, so a force that is asked for
/// without end settles below continuous, without a step. Sources: the thermal model of a motor with
/// one time constant, e.g. IEC 60034-11; tau is our choice, the order of a small motor's winding.
///
/// A device that reports warm motors itself halves the ceiling (of continuous where it is known,
/// else of the peak) over kWarmRamp_s; it comes back over kCoolRamp_s after the report has ended.
class ThermalLimit {
public:
  ThermalLimit() = default;
  /// Motors that are warm already, h in N^2; what is not a number is taken for cold.
  explicit ThermalLimit(double heat_n2) noexcept : heat_n2_(heat_n2 > 0 ? heat_n2 : 0) {}

  static constexpr double kTimeConstant_s = 30;
  static constexpr double kWarmRamp_s = 1, kCoolRamp_s = 10;

  /// After a tick with that force, N; reported_warm: the device's own word.
  void advance(const ThermalSettings& settings, double force_n, bool reported_warm) noexcept;
  /// The longest force now, N; never above peak_n.
  [[nodiscard]] double ceiling_n(const ThermalSettings& settings) const noexcept;
  /// The force limit is noticeably lowered: from 0.95 of the peak down, until the ceiling is the
  /// peak again and h below 0.4 continuous^2, so that it does not change with every push.
  [[nodiscard]] bool derating() const noexcept { return derating_; }
  /// N, what a force that is asked for without end settles at: the C of C^2 = h, or half of
  /// continuous (of the peak where it is not known) when the device itself reports warm motors.
  [[nodiscard]] double steady_limit_n(const ThermalSettings& settings) const noexcept;
  /// h, N^2
  [[nodiscard]] double heat_n2() const noexcept { return heat_n2_; }

private:
  double heat_n2_ = 0;
  double warm_ = 0; ///< 0: cool, 1: the report's ceiling is fully on
  bool reported_ = false, derating_ = false;
};

} // namespace tactus::haptic
