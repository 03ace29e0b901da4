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
  static constexpr std::size_t kMost = 32, kFewest = 5;
  /// Readings and forces in turn; false, and nothing changes, unless there are 5 to 32 points and
  /// both rise throughout.
  bool set(std::span<const double> readings_and_forces) noexcept;
  void clear() noexcept { count_ = 0; }
  /// The reading itself without a table; beyond its ends the outer lines go on.
  [[nodiscard]] double force(double reading) const noexcept;

private:
  std::size_t count_ = 0;
  std::array<double, kMost> reading_{}, force_{};
};

/// One sensor under the sole: calibration, baseline that follows while the foot is in the air,
/// second-order low-pass of 200 Hz, slope by least squares over 5 ms.
class SoleChannel {
public:
  void prepare(double sample_rate); ///< may allocate
  void reset() noexcept;
  /// `lifted`: the foot is in the air, the baseline may follow, down to `lowest_n`.
  void next(double force_n, bool lifted, double lowest_n = -20) noexcept;
  [[nodiscard]] double force() const noexcept { return force_; }         ///< N
  [[nodiscard]] double slope() const noexcept { return slope_ * rate_; } ///< N/s

private:
  void start_sums() noexcept;

  double rate_ = 48000, force_ = 0, slope_ = 0, baseline_ = 0;
  double follow_slow_ = 0, follow_fast_ = 0;
  double b0_ = 1, b1_ = 0, b2_ = 0, a1_ = 0, a2_ = 0, s1_ = 0, s2_ = 0; // low-pass
  std::vector<double> recent_;
  std::size_t at_ = 0;
  double sum_ = 0, weighted_ = 0; // over the last 5 ms
};

/// Two sensors of one foot to its forces and the phases of its steps. A region lands when it
/// carries 5 % of the body's weight, or 2.5 % while rising as fast as a step does, and lifts
/// below 2.5 %; a stance lasts at least 80 ms and a swing 60 ms, so that noise makes no steps. How
/// hard it landed is told 2.7 ms after it first carried 1 %, or as soon as it has landed: before,
/// the slope is that of the air. A ball that carries 1 % under a heel that stands has landed, too:
/// it takes on weight slowly.
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
    double usual_speed, usual_slope; ///< landing speed in m/s, weights a second by then
    bool down = false, landed = false;
    double since_s = 1, touching_s = 0;
  };
  void update(Region& region, double force_n, bool stands, double& landing, bool& lifted) noexcept;

  double weight_n_ = 700, step_s_ = 1.0 / 48000;
  Calibration heel_table_, ball_table_;
  Region heel_{{}, 0.5, 12}, ball_{{}, 0.3, 0.3};
};

} // namespace tactus::footstep
