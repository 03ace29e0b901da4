#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::footstep {

/// Signals under heel [0] and ball [1]: one operation works on both.
using HeelBall [[gnu::vector_size(2 * sizeof(double))]] = double;

/// Band of the recoil actuators under a sandal, 50 to 500 Hz (-3 dB): elliptic, fourth order below
/// (0.1 dB ripple, 40 dB) and sixth above (0.1 dB, 60 dB), bilinear with both edges in place. White
/// noise leaves it with less than -37 dB of its power outside 40 to 600 Hz; its delay at 200 Hz is
/// below 2 ms. Butterworth filters of fourth order leave -14 dB outside.
class HapticBand {
public:
  void prepare(double sample_rate) noexcept;
  void reset() noexcept {
    state_ = {};
    dc_ = HeelBall{};
  }
  HeelBall next(HeelBall x) noexcept;

private:
  static constexpr std::size_t kSections = 5;
  struct Section {
    double b0 = 0, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  };
  struct State {
    HeelBall s1{}, s2{};
  };
  std::array<Section, kSections> section_{};
  std::array<State, kSections> state_{};
  HeelBall dc_{}; ///< taken away before
  double dc_coefficient_ = 0;
};

/// Undoes an actuator's response: peaking filters an octave or so wide, at most 16.
class DriveEqualiser {
public:
  static constexpr std::size_t kMaxFilters = 16;
  void prepare(double sample_rate) noexcept;
  /// Frequencies in Hz (20..2000, rising) and gains in dB (-24..24) in turn; the curve passes
  /// through them. False, and nothing changes, when they are none of that. An empty list: flat.
  bool set(std::span<const double> frequencies_and_gains) noexcept;
  void reset() noexcept { state_ = {}; }
  double next(double x) noexcept;

private:
  void compute_coefficients() noexcept;
  struct Section {
    double b0 = 1, b1 = 0, b2 = 0, a1 = 0, a2 = 0;
  };
  struct State {
    double s1 = 0, s2 = 0;
  };
  double sample_rate_ = 48000;
  std::size_t count_ = 0;
  std::array<double, kMaxFilters> frequency_hz_{}, target_db_{};
  std::array<Section, kMaxFilters> section_{};
  std::array<State, kMaxFilters> state_{};
};

/// Keeps an acceleration within a limit: gain falls at once, recovers within 50 ms. Never exceeded.
class PeakLimit {
public:
  void prepare(double sample_rate) noexcept;
  double next(double x, double limit) noexcept;
  void reset() noexcept { gain_ = 1; }

private:
  double gain_ = 1, recover_ = 0.001;
};

/// The motion of the ground under heel and ball to the two actuators of one sandal: band, equaliser
/// and delay, each within the limit. Each actuator plays what is under it; of a `common` share both
/// play the whole foot's motion, by their parts of the force (Nordahl et al. 2010 drive both with
/// one signal).
class Drive {
public:
  static constexpr double kMaxDelay = 0.2; ///< s
  struct Settings {
    double gain = 1;          ///< of the drive for the ground's motion
    double sensitivity_g = 3; ///< acceleration (in g) at a drive of 1
    double limit_g = 3;       ///< largest acceleration
    double delay_s = 0;
    double common = 0; ///< 0..1
  };
  void prepare(double sample_rate); ///< may allocate
  void set(const Settings& settings) noexcept;
  bool equalise(std::span<const double> table) noexcept;
  void reset() noexcept;

  struct Pair {
    double heel = 0, ball = 0;
  };
  /// Motions under heel and ball. Forces decide the shares of what is common; without any the last
  /// shares stay.
  Pair next(double heel_vibration, double ball_vibration, double heel_n, double ball_n) noexcept;

private:
  /// To one actuator.
  struct Channel {
    DriveEqualiser equaliser;
    PeakLimit limit;
    std::vector<double> line;
    void reset() noexcept;
    double next(double x, std::size_t at, std::size_t delay) noexcept;
  };
  Settings settings_;
  double sample_rate_ = 48000, limit_ = 1;
  double last_heel_n_ = 1, last_total_n_ = 1; ///< when the foot last bore a load
  HapticBand band_;
  std::array<Channel, 2> channel_; ///< heel, ball
  std::size_t write_index_ = 0, delay_ = 0;
  std::size_t silent_samples_ = 0,
              ring_out_samples_ = 48000; ///< samples without motion; after so many nothing is left
  bool at_rest_ = false;
};

} // namespace tactus::footstep
