#pragma once

#include "core/geometry/vec3.hpp"

namespace tactus::devices::falcon {

/// Detects frozen encoders of a Falcon: the counts stay constant although a force acts. This
/// happens, and lasts until the firmware is reloaded (libnifalcon's issues 24, 32, 45).
///
/// Constant counts alone prove nothing: they also occur when a hand holds still against a constant
/// force, since static friction f holds the handle within a band of 2 f of force. But when the
/// force has changed by more than that band, a handle that is not clamped has moved by more than a
/// count. The detector low-passes the force (a vibration changes no count) and goes through three
/// states:
///
///   suspicion  the force is above 2 f and no count has changed for 3 s, or for 0.3 s while the
///              force differed by more than 2 f from its value at the last change;
///   test       the force fades out over 0.5 s. The first count that changes ends the test, and the
///              force returns over 0.2 s;
///   frozen     the force has been zero for 0.2 s and no count has changed; ends when one changes.
///
/// A hand that holds very still is tested again after 6 s, then every 12 s; motion that lasts sets
/// the wait back to 3 s. Limit: a clamped grip, which the whole force moves by less than a count
/// (35 um), counts as frozen. At 1 N, such a grip is stiffer than 29 kN/m.
class FrozenEncoderDetector {
public:
  /// Static friction f at the Falcon's grip, N. Not measured but chosen on the large side. If the
  /// true friction is smaller, the test is safer. If it is larger, a still hand is tested
  /// needlessly but passes, since it moves when the whole force ends.
  static constexpr double kFriction_n = 0.4;
  static constexpr double kBand_n = 2 * kFriction_n;
  static constexpr double kWait_s = 3, kMaxWait_s = 12, kMismatch_s = 0.3;
  static constexpr double kFade_s = 0.5, kZeroForce_s = 0.2, kReturn_s = 0.2;

  void reset() noexcept { *this = {}; }
  /// One tick of period_s. changed: any count differs from the last tick's. commanded_n: the
  /// requested force before gain(), N. active: the device is homed, so that counts and force are
  /// meaningful; if false, calls reset().
  void update(bool changed, const Vec3& commanded_n, double period_s, bool active) noexcept;

  /// Factor for the requested force, 0 to 1.
  [[nodiscard]] double gain() const noexcept { return gain_; }
  [[nodiscard]] bool frozen() const noexcept { return frozen_; }

private:
  void end_test(double period_s) noexcept;

  Vec3 commanded_{}, sent_{}; // low-passed, N
  Vec3 reference_{};          // sent_ at the last change of a count, N
  double still_s_ = 0;        // time under force since a count changed
  double mismatch_s_ = 0;     // time that the force was outside the band around reference_
  double zero_force_s_ = 0;   // time since the force has faded out
  double wait_s_ = kWait_s;   // still_s_ at which the next test begins
  double since_test_s_ = 1e9;
  double gain_ = 1;
  int moved_ = 0; // ticks in which a count changed, more than kSettled_s after a test
  bool testing_ = false, frozen_ = false;
};

} // namespace tactus::devices::falcon
