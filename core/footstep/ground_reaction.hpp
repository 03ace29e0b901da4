#pragma once

namespace tactus::footstep {

/// Who walks, and how.
struct Walker {
  double speed_m_per_s = 1.4;
  double weight_n = 700;
  double shoe = 0.4; ///< hardness of sole and heel: 0 barefoot or soft, 1 hard
  bool run = false;
};

/// Vertical force of the ground on one foot over its stance, x = time / stance in 0..1.
/// Walking: two peaks and a valley between them, by straight-line interpolation over speed of
/// published values (0.8, 1.1, 1.4, 1.8 m/s); half cosines join them, and the flanks outside are
/// a mixture of sine and squared sine whose share is chosen so that the mean over the stance is
/// weight / (2 duty), the impulse that a steady walk needs. Peaks and mean are thus both exact;
/// three bell curves with a free middle cannot have both (docs/footstep.md).
/// Running: half a sine with the same mean rule, no double support.
/// A hard heel adds a transient of up to 0.6 weights about 16 ms after contact.
class GroundReaction {
public:
  GroundReaction() { set({}); }
  /// Speed is held within 0.3..2.5 m/s for walking and 1.5..8 m/s for running.
  void set(const Walker& walker) noexcept;

  /// Force in N at x in 0..1; 0 outside.
  [[nodiscard]] double force(double x) const noexcept;
  [[nodiscard]] double stance_s() const noexcept { return stance_s_; }
  [[nodiscard]] double stride_s() const noexcept { return stride_s_; }
  [[nodiscard]] double duty() const noexcept { return stance_s_ / stride_s_; }

  /// Part of the force under the heel; the rest is under the ball.
  [[nodiscard]] static double heel_share(double x) noexcept;

private:
  double weight_n_ = 700;
  double stance_s_ = 0.7, stride_s_ = 1.1;
  bool run_ = false;
  double peak_ = 1;                                                      // weights, running
  double first_ = 1, first_at_ = 0.22, valley_ = 0.7, valley_at_ = 0.48; // weights, of the stance
  double second_ = 1, second_at_ = 0.77, sine_share_ = 0.5;
  double transient_ = 0, transient_width_ = 0.05;
};

} // namespace tactus::footstep
