#pragma once

#include <array>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::footstep {

/// Signals under heel [0] and ball [1] in one vector.
using HeelBall [[gnu::vector_size(2 * sizeof(double))]] = double;

/// Band-pass for the recoil actuators of a sandal, 50 to 500 Hz (-3 dB). Elliptic filters: a
/// high-pass of fourth order (0.1 dB ripple, 40 dB stop band) and a low-pass of sixth order (0.1
/// dB, 60 dB), by the bilinear transform with prewarped edges. Less than -37 dB of the power of
/// filtered white noise lies outside 40 to 600 Hz; Butterworth filters of fourth order leave -14
/// dB. The delay at 200 Hz is below 2 ms.
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
  HeelBall dc_{}; ///< mean of the input, subtracted first
  double dc_coefficient_ = 0;
};

/// Equalises an actuator's frequency response by up to 16 peaking filters about an octave wide.
class ActuatorEqualiser {
public:
  static constexpr std::size_t kMaxFilters = 16;
  void prepare(double sample_rate) noexcept;
  /// Alternating frequencies in Hz (20..2000, increasing) and gains in dB (-24..24); the response
  /// passes through them. An empty list is flat. Returns false, and changes nothing, for any other
  /// list.
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

/// Peak limiter: the gain falls at once and recovers within 50 ms, so the limit is never exceeded.
class PeakLimit {
public:
  void prepare(double sample_rate) noexcept;
  double next(double x, double limit) noexcept;
  void reset() noexcept { gain_ = 1; }

private:
  double gain_ = 1, recover_ = 0.001;
};

/// Signals for the two actuators of one sandal from the vibration under heel and ball: band-pass,
/// equaliser, delay and limiter. Each actuator gets the vibration under it. The share `common` of
/// the signal is the vibration of the whole foot, divided between both actuators in proportion to
/// the forces (Nordahl et al. 2010 feed one signal to both).
class ActuatorSignals {
public:
  static constexpr double kMaxDelay = 0.2; ///< s
  struct Settings {
    double gain = 1;          ///< signal per vibration
    double sensitivity_g = 3; ///< acceleration at a signal of 1, g
    double limit_g = 3;       ///< largest acceleration, g
    double delay_s = 0;       ///< 0..kMaxDelay
    double common = 0;        ///< 0..1
  };
  void prepare(double sample_rate); ///< may allocate
  void set(const Settings& settings) noexcept;
  /// ActuatorEqualiser::set() for both actuators.
  bool equalise(std::span<const double> table) noexcept;
  void reset() noexcept;

  struct Pair {
    double heel = 0, ball = 0;
  };
  /// Computes one sample. The forces, N, determine the shares of the common signal; without force
  /// the last shares are kept.
  Pair next(double heel_vibration, double ball_vibration, double heel_n, double ball_n) noexcept;

private:
  /// Signal path of one actuator.
  struct Channel {
    ActuatorEqualiser equaliser;
    PeakLimit limit;
    std::vector<double> line;
    void reset() noexcept;
    double next(double x, std::size_t at, std::size_t delay) noexcept;
  };
  Settings settings_;
  double sample_rate_ = 48000, limit_ = 1;
  double last_heel_n_ = 1, last_total_n_ = 1; ///< the last forces of a loaded foot
  HapticBand band_;
  std::array<Channel, 2> channel_; ///< heel, ball
  std::size_t write_index_ = 0, delay_ = 0;
  std::size_t silent_samples_ = 0;       ///< samples without vibration so far
  std::size_t ring_out_samples_ = 48000; ///< number of samples after which the filters have decayed
  bool at_rest_ = false;
};

} // namespace tactus::footstep
