#pragma once

#include "core/geometry/vec3.hpp"

namespace tactus::devices::falcon {

/// Finds encoders that have frozen, which happens until the firmware is loaded again (libnifalcon's
/// issues 24, 32, 45): position stands still to the count while force goes on.
///
/// A hand that holds still against a constant force shows constant counts too, as long as it wants
/// to: static friction f holds the handle within a band of 2 f of force. So stillness alone proves
/// nothing, and what decides is a change of the force: when it has changed by more than the band, a
/// handle that is not clamped has moved by more than a count. The watch looks at the sent force,
/// low-passed (a vibration moves no count), and
///
///   suspects  when no count has changed while the force changed by more than 2 f for 0.3 s, or for
///             3 s under a force of more than 2 f;
///   asks      by taking the force away over 0.5 s; the first count that changes is the answer, and
///             the force returns over 0.2 s;
///   knows     when the force has been zero for 0.2 s and no count has changed: frozen, until one
///             does.
///
/// A hand that holds very still is asked again after 6 s, then every 12 s; real motion brings the 3
/// s back. Not distinguished from frozen: a grip that is clamped, so that the whole force moves it
/// by less than a count (35 um): stiffer than 29 kN/m for 1 N.
class FrozenEncoderDetector {
public:
  /// Of the Falcon's static friction at the grip, N. Not measured by us: a guess on the safe side;
  /// with less friction all the better, with more a still hand is asked and believed all the same,
  /// as it feels the whole force go.
  static constexpr double kFriction_n = 0.4;
  static constexpr double kBand_n = 2 * kFriction_n;
  static constexpr double kWait_s = 3, kMaxWait_s = 12, kMismatch_s = 0.3;
  static constexpr double kFade_s = 0.5, kZeroForce_s = 0.2, kReturn_s = 0.2;

  void reset() noexcept { *this = {}; }
  /// One tick: whether any count has changed since the last one, and the force that was asked for,
  /// before gain(), N. active: homed, so that counts and force mean something.
  void update(bool changed, const haptic::Vec3& commanded_n, double period_s, bool active) noexcept;

  /// What the force is to be multiplied with, 0 to 1.
  [[nodiscard]] double gain() const noexcept { return gain_; }
  [[nodiscard]] bool frozen() const noexcept { return frozen_; }

private:
  void update_test(double period_s) noexcept;

  haptic::Vec3 commanded_{}, sent_{}; // low-passed
  haptic::Vec3 reference_{};          // sent_ at the last change of a count
  double still_s_ = 0;                // since a count changed, under force
  double mismatch_s_ = 0;             // since the force left the band around the reference
  double zero_force_s_ = 0;           // since the force was taken away
  double wait_s_ = kWait_s;
  double since_test_s_ = 1e9;
  double gain_ = 1;
  int moved_ = 0; // ticks in which a count changed, well after a question
  bool testing_ = false, frozen_ = false;
};

} // namespace tactus::devices::falcon
