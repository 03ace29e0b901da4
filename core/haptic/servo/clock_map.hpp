#pragma once

#include <cstdint>

namespace tactus::haptic {

/// Maps the clock of a servo's thread to the host's logical time. The host's time jumps by blocks
/// about a true one, kept by its sound card, and the two drift apart by up to 100 ppm:
///
///   ahead' = drift + limited difference per second,   drift' = kGain_per_s times that difference
///
/// so that the map lies in the middle of the jumps whatever the drift, and keeps the distance of
/// two moments to 2 kMaxDrift. Where the two are kLeap_ms apart, as after a stall or in a host that
/// computes as fast as it can, it leaps and counts that.
class ClockMap {
public:
  static constexpr double kMaxDrift = 2e-4, kLeap_ms = 50, kGain_per_s = 0.01;

  /// The two clocks now.
  void follow(double host_ms, double servo_s) noexcept;
  /// The host's time of a moment of the servo's clock, ms.
  [[nodiscard]] double host_ms(double servo_s) const noexcept { return servo_s * 1e3 + ahead_ms_; }
  /// By how much the host's clock is faster, to 20 ppm, learned within two minutes.
  [[nodiscard]] double drift_ppm() const noexcept { return 1e6 * drift_; }
  [[nodiscard]] std::uint64_t leaps() const noexcept { return leaps_; }

private:
  double ahead_ms_ = 0, servo_s_ = 0, drift_ = 0;
  std::uint64_t leaps_ = 0;
  bool started_ = false;
};

} // namespace tactus::haptic
