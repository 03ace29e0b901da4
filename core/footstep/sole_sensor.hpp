#pragma once

#include "core/footstep/step_event.hpp"

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::footstep {

/// From what a sensor reads to newtons: straight lines between rising points.
class Calibration {
public:
  static constexpr std::size_t kMaxPoints = 32, kMinPoints = 5;
  /// Readings and forces in turn; false, and nothing changes, unless there are 5 to 32 points and
  /// both rise throughout.
  bool set(std::span<const double> readings_and_forces) noexcept;
  void clear() noexcept { count_ = 0; }
  /// The reading itself without a table; beyond its ends the outer lines go on.
  [[nodiscard]] double force(double reading) const noexcept;

private:
  std::size_t count_ = 0;
  std::array<double, kMaxPoints> reading_{}, force_{};
};

/// One sensor under the sole: calibration, baseline that follows while the foot is in the air,
/// second-order low-pass of 200 Hz, slope by least squares over 5 ms.
class SoleChannel {
public:
  void prepare(double sample_rate); ///< may allocate
  void reset() noexcept;
  /// `lifted`: the foot is in the air, the baseline may follow, down to `lowest_n`. `free`: this
  /// part of it is, floor and noise are followed; what rises by more than touch_threshold_n is no
  /// noise.
  void next(double force_n, bool lifted, bool free = false, double touch_threshold_n = 20,
            double lowest_n = -20) noexcept;
  [[nodiscard]] double force() const noexcept { return force_; }         ///< N
  [[nodiscard]] double slope() const noexcept { return slope_ * rate_; } ///< N/s
  /// Above what the sensor read during the last 30 ms in which it was free, N.
  [[nodiscard]] double rise() const noexcept { return rise_; }
  /// The rise that noise does not reach, N: seven of its standard deviations, within 0.15 to 2.5 %
  /// of the weight.
  [[nodiscard]] double touch_threshold_n(double weight_n) const noexcept;
  /// What it reads now is the floor.
  void rebase_floor() noexcept { floor_ += rise_; }

private:
  void start_sums() noexcept;

  double rate_ = 48000, force_ = 0, slope_ = 0, baseline_ = 0;
  double slow_coefficient_ = 0, fast_coefficient_ = 0, floor_coefficient_ = 0,
         noise_coefficient_ = 0;
  double floor_ = 0, rise_ = 0, variance_ = 0, noise_weight_ = 0; ///< known: weight of the variance
  double b0_ = 1, b1_ = 0, b2_ = 0, a1_ = 0, a2_ = 0, s1_ = 0, s2_ = 0; // low-pass
  std::vector<double> window_;
  std::size_t write_index_ = 0;
  double sum_ = 0, index_weighted_sum_ = 0; // over the last 5 ms
};

/// Two sensors of one foot to its forces and the phases of its steps. A region lands once it has
/// risen for 2.2 ms (3.5 ms if firmly) above what it read in the air by more than noise
/// (touch_threshold_n), and how hard is told by the slope then; at the latest it lands when it
/// carries 5 % of the body's weight. It lifts below 2.5 %, or, if it never carried 5 %, where it
/// began. A stance lasts at least 80 ms and a swing 60 ms. A pad of F ~ x^1.5 (Hertz) pressed at v
/// has a slope ~ v^1.5 by that time.
class SoleSensor {
public:
  void prepare(double sample_rate); ///< may allocate
  void set(double weight_n) noexcept;
  void reset() noexcept;
  Calibration& heel_calibration() noexcept { return heel_table_; }
  Calibration& ball_calibration() noexcept { return ball_table_; }

  /// Readings of one sample; what is no number is no force.
  SoleState next(double heel_reading, double ball_reading) noexcept;
  [[nodiscard]] bool in_stance() const noexcept { return heel_.down || ball_.down; }

private:
  struct Region {
    SoleChannel channel;
    double typical_speed, typical_slope; ///< landing speed in m/s, weights a second by then
    bool down = false, loaded = false;   ///< loaded: has carried 5 % since it landed
    double since_s = 1, contact_s = 0, touch_threshold_n = 17.5;
  };
  /// `stands`: the other part of the sole is down already.
  void update(Region& region, double force_n, bool other_down, double& landing,
              bool& lifted) noexcept;

  double weight_n_ = 700, step_s_ = 1.0 / 48000;
  Calibration heel_table_, ball_table_;
  Region heel_, ball_;
};

} // namespace tactus::footstep
