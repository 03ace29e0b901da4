#pragma once

#include <cstdint>

namespace tactus::haptic {

/// Maps the clock of a servo's thread to the host's logical time. The host's time advances in jumps
/// of a block, at the mean rate of its sound card, and the two clocks drift apart by up to 100 ppm:
///
///   ahead' = drift + limited difference per second,   drift' = kGain_per_s times that difference
///
/// so that the map runs through the middle of the jumps at any drift, with a relative error of time
/// intervals below 2 kMaxDrift. If the difference exceeds kLeap_ms, as after a stall or in a host
/// that computes faster than real time, the map jumps to the host's time and counts the jump.
class ClockMap {
public:
  static constexpr double kMaxDrift = 2e-4, kLeap_ms = 50, kGain_per_s = 0.01;

  /// Updates the map from the present time of both clocks.
  void follow(double host_ms, double servo_s) noexcept;
  /// The host's time for a time of the servo's clock, ms.
  [[nodiscard]] double host_ms(double servo_s) const noexcept { return servo_s * 1e3 + ahead_ms_; }
  /// Rate by which the host's clock is faster, ppm; accurate to 20 ppm after two minutes.
  [[nodiscard]] double drift_ppm() const noexcept { return 1e6 * drift_; }
  [[nodiscard]] std::uint64_t leaps() const noexcept { return leaps_; }

private:
  double ahead_ms_ = 0, servo_s_ = 0, drift_ = 0;
  std::uint64_t leaps_ = 0;
  bool started_ = false;
};

} // namespace tactus::haptic
