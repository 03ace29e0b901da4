#pragma once

#include "core/footstep/step_event.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::footstep {

/// Converts sensor readings to newtons, by linear interpolation between calibration points.
class Calibration {
public:
  static constexpr std::size_t kMaxPoints = 32, kMinPoints = 5;
  /// Alternating readings and forces, N. Returns false, and changes nothing, unless there are 5 to
  /// 32 points and both increase strictly.
  bool set(std::span<const double> readings_and_forces) noexcept;
  void clear() noexcept { count_ = 0; }
  /// Force of a reading, N, extrapolated linearly outside the table. Without a table, the reading
  /// itself.
  [[nodiscard]] double force(double reading) const noexcept;

private:
  std::size_t count_ = 0;
  std::array<double, kMaxPoints> reading_{}, force_{};
};

/// Signal of one sensor under the sole: baseline subtraction, second-order low-pass at 200 Hz,
/// slope by least squares over 5 ms, and an estimate of the noise in the air.
class SoleChannel {
public:
  void prepare(double sample_rate); ///< may allocate
  void reset() noexcept;
  /// How the baseline may follow higher readings. In stance: not at all. In the air: as slowly as
  /// sensors drift, until a landing decides whether the rise was a load (keep_baseline()). In a
  /// swing: freely.
  enum class Follow { kStance, kAir, kSwing };
  /// Processes one sample, force_n in N. `free`: this region is in the air, so floor and noise are
  /// updated. An increase above touch_threshold_n does not count as noise, nor does the share of
  /// the other region's force.
  void next(double force_n, Follow follow, double weight_n, bool free = false,
            double touch_threshold_n = 20, double crosstalk_n = 0) noexcept;
  [[nodiscard]] double force() const noexcept { return force_; }         ///< N
  [[nodiscard]] double slope() const noexcept { return slope_ * rate_; } ///< N/s
  /// Rise above the floor, N. The floor is the reading while free, low-passed with 30 ms.
  [[nodiscard]] double rise() const noexcept { return rise_; }
  /// Change of the reading within 30 ms, N.
  [[nodiscard]] double change() const noexcept { return reading_ - delayed_; }
  /// Rise that noise does not exceed, N: seven standard deviations, clamped to 0.15..8 % of the
  /// weight.
  [[nodiscard]] double touch_threshold_n(double weight_n) const noexcept;
  /// Makes the current reading the floor.
  void rebase_floor() noexcept { floor_ += rise_; }
  /// Makes the current reading the baseline.
  void rebase() noexcept { baseline_ = known_baseline_ = reading_; }
  /// To be called at a landing. `keep` false: the landing was so slow that the rise before it was
  /// load, not drift.
  void keep_baseline(bool keep) noexcept {
    if (keep)
      known_baseline_ = baseline_;
    else
      baseline_ = known_baseline_;
  }

private:
  void start_sums() noexcept;

  double rate_ = 48000, force_ = 0, slope_ = 0, baseline_ = 0;
  double reading_ = 0, delayed_ = 0; ///< low-passed reading; the same, low-passed again with 30 ms
  double known_baseline_ = 0;        ///< baseline of the last swing
  double swing_coefficient_ = 0, fast_coefficient_ = 0, floor_coefficient_ = 0,
         noise_coefficient_ = 0;
  double floor_ = 0, rise_ = 0, variance_ = 0;
  double noise_weight_ = 0; ///< 0..1, share of variance_ that has been measured
  double b0_ = 1, b1_ = 0, b2_ = 0, a1_ = 0, a2_ = 0, s1_ = 0, s2_ = 0; // low-pass
  std::vector<double> window_;
  std::size_t write_index_ = 0;
  double sum_ = 0, index_weighted_sum_ = 0; // sums over the last 5 ms
};

/// Forces and step phases of one foot from its two sensors.
///
/// A region lands once its force has exceeded the noise (touch_threshold_n) for 2.2 ms, or for 3.5
/// ms if the contact is firm. It lands at the latest when it carries 5 % of the body's weight. The
/// slope at that moment gives the landing speed v: a pad of F ~ x^1.5 (Hertz) has a slope ~ v^1.5.
/// The region lifts below 2.5 % of the weight. If it never carried 5 %, it lifts below half of the
/// noise threshold, or after 0.5 s. A stance lasts at least 80 ms, a swing at least 60 ms.
///
/// Three errors of sensors are handled. Crosstalk: part of the force under one region reaches the
/// sensor of the other region. All thresholds rise by that part, which is taken as 8 % until a step
/// shows a smaller one. Drift of zero: a region whose force falls from half of its peak to an
/// eighth within 0.2 s and then stays constant for 60 ms is in the air, whatever reading remains.
/// Plugging in: a force that jumps within one sample and then stays constant sets the region
/// standing, without a landing.
class SoleSensor {
public:
  void prepare(double sample_rate); ///< may allocate
  void set(double weight_n) noexcept;
  void reset() noexcept;
  Calibration& heel_calibration() noexcept { return heel_table_; }
  Calibration& ball_calibration() noexcept { return ball_table_; }

  /// Readings of one sample; NaN counts as no force.
  SoleState next(double heel_reading, double ball_reading) noexcept;
  [[nodiscard]] bool in_stance() const noexcept { return heel_.down || ball_.down; }

private:
  struct Region {
    SoleChannel channel;
    double typical_speed, typical_slope; ///< landing speed, m/s, and slope of the force, weights
                                         ///< per second
    bool down = false, loaded = false;   ///< loaded: has carried 5 % since it landed
    double since_s = 1, contact_s = 0, touch_threshold_n = 56;
    double crosstalk = 0.08; ///< part of the other region's force
    bool swings = false;     ///< lifted like a foot that takes a step
    double peak = 0, fall_s = 0,
           rest_s = 0; ///< of this stance: peak, weights; duration of its fall; time without change
    double last_n = 0, jump_n = 0, jump_s = -1; ///< jump_s: time since a jump to jump_n; below 0:
                                                ///< none
  };
  void update(Region& region, const Region& other, double force_n, double& landing,
              bool& lifted) noexcept;
  /// Detects a jump of the reading, and forgets it if the reading continues to change.
  void watch_jump(Region& region, double force_n) noexcept;
  [[nodiscard]] bool lands(Region& region, const Region& other, double& landing) noexcept;
  [[nodiscard]] bool lifts(Region& region, const Region& other) noexcept;

  double weight_n_ = 700, step_s_ = 1.0 / 48000;
  Calibration heel_table_, ball_table_;
  Region heel_, ball_;
};

} // namespace tactus::footstep
