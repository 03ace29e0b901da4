#pragma once

#include <array>
#include <complex>

namespace tactus::reed {

/// A player's ear: compares the pitch that sounds with the pitch meant, and says by how much the
/// instrument is to be played sharper or flatter.
///
/// The bore pressure is multiplied by exp(-i 2 pi f t), f the pitch meant, and smoothed by two
/// one-pole filters; the angle that the result turns by is the phase run ahead, and the trim
/// follows with its negative, an integral controller with 0.1 s (a vibrato of 5 Hz passes). It
/// keeps still where there is nothing to hear: no pressure at that pitch, or a pitch more than two
/// and a half semitones away (another register: no trim would bring it back), and never goes beyond
/// a little over four semitones.
class Ear {
public:
  static constexpr int kPeriod = 32; // samples of a hearing

  void prepare(double sample_rate) noexcept;
  /// Forgets what it heard and its trim.
  void reset() noexcept;
  /// Pitch meant, Hz, > 0 and below half the sample rate. The trim stays.
  void mean(double frequency_hz) noexcept;
  /// The next samples of bore pressure, Pa; at most kPeriod between two calls of trim().
  void listen(const double* bore_pressure, int count) noexcept;
  /// Due after each kPeriod samples: natural logarithm of the factor by which the pitch is to be
  /// changed from what linear theory chose.
  double trim() noexcept;

private:
  double sample_rate_ = 48000, frequency_ = 0;
  std::array<double, kPeriod> cosine_{}, sine_{};
  struct Sums {
    double real = 0, imaginary = 0, power = 0;
  };
  Sums even_, odd_;
  std::complex<double> turn_ = 1, phase_ = 1, smooth_ = 0, smoother_ = 0;
  double pole_ = 0, loudness_ = 0, power_pole_ = 0, trim_ = 0;
  int place_ = 0;
};

} // namespace tactus::reed
