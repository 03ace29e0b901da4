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
  /// Force of a reading, N; outside the table extrapolated linearly. Without a table, the reading.
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
  /// One sample, force_n in N. `lifted`: the whole foot is in the air, so the baseline is updated,
  /// limited to at least `lowest_n`. `free`: this part is in the air, so floor and noise are
  /// updated; rises above touch_threshold_n do not count as noise.
  void next(double force_n, bool lifted, bool free = false, double touch_threshold_n = 20,
            double lowest_n = -20) noexcept;
  [[nodiscard]] double force() const noexcept { return force_; }         ///< N
  [[nodiscard]] double slope() const noexcept { return slope_ * rate_; } ///< N/s
  /// Rise above the floor, N. The floor is the reading while free, low-passed with 30 ms.
  [[nodiscard]] double rise() const noexcept { return rise_; }
  /// Rise that noise does not reach, N: seven standard deviations, clamped to 0.15..2.5 % of the
  /// weight.
  [[nodiscard]] double touch_threshold_n(double weight_n) const noexcept;
  /// Makes the current reading the floor.
  void rebase_floor() noexcept { floor_ += rise_; }

private:
  void start_sums() noexcept;

  double rate_ = 48000, force_ = 0, slope_ = 0, baseline_ = 0;
  double slow_coefficient_ = 0, fast_coefficient_ = 0, floor_coefficient_ = 0,
         noise_coefficient_ = 0;
  double floor_ = 0, rise_ = 0, variance_ = 0;
  double noise_weight_ = 0; ///< 0..1, share of variance_ that has been measured
  double b0_ = 1, b1_ = 0, b2_ = 0, a1_ = 0, a2_ = 0, s1_ = 0, s2_ = 0; // low-pass
  std::vector<double> window_;
  std::size_t write_index_ = 0;
  double sum_ = 0, index_weighted_sum_ = 0; // over the last 5 ms
};

/// Forces and step phases of one foot from its two sensors.
///
/// A region lands once its force has exceeded the noise (touch_threshold_n) for 2.2 ms, or for 3.5
/// ms if the contact is firm, and at the latest when it carries 5 % of the body's weight. The slope
/// at that moment gives the landing speed v: a pad of F ~ x^1.5 (Hertz) has a slope ~ v^1.5. The
/// region lifts below 2.5 % of the weight; if it never carried 5 %, below half of the noise
/// threshold, or after 0.5 s. A stance lasts at least 80 ms, a swing at least 60 ms.
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
    double typical_speed, typical_slope; ///< landing speed, m/s, and its slope, weights a second
    bool down = false, loaded = false;   ///< loaded: has carried 5 % since it landed
    double since_s = 1, contact_s = 0, touch_threshold_n = 17.5;
  };
  /// `other_down`: the other part of the sole is on the ground.
  void update(Region& region, double force_n, bool other_down, double& landing,
              bool& lifted) noexcept;

  double weight_n_ = 700, step_s_ = 1.0 / 48000;
  Calibration heel_table_, ball_table_;
  Region heel_, ball_;
};

} // namespace tactus::footstep
