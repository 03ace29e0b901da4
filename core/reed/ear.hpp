#pragma once

#include <array>
#include <complex>
#include <cstddef>

namespace tactus::reed {

/// A player's ear: compares the pitch that sounds with the pitch meant, and says by how much the
/// instrument is to be played sharper or flatter.
///
/// The bore pressure is multiplied by exp(-i 2 pi f t), f the pitch meant, and smoothed by two
/// one-pole filters; the angle that the result turns by is the phase run ahead, and the trim
/// follows with its negative, an integral controller with 0.1 s (a vibrato of 5 Hz passes). It
/// keeps still where there is nothing to hear: no pressure at that pitch, or a pitch more than two
/// semitones away (another register: no trim would bring it back, and one would carry the next note
/// off), and never goes farther itself.
///
/// What a semitone needed is remembered, as a player remembers it, and is where its next note
/// starts; a note that is new starts as the one before ended.
class Ear {
public:
  static constexpr int kPeriod = 32; // samples of a hearing

  Ear() noexcept { forget(); }
  void prepare(double sample_rate) noexcept;
  /// Forgets what it heard and its trim.
  void reset() noexcept;
  /// Forgets what the notes needed: the instrument is another one.
  void forget() noexcept { known_.fill(kUnknown); }
  /// Pitch meant, Hz, > 0 and below half the sample rate. The trim stays, or becomes what that
  /// semitone is known to need.
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
  static constexpr double kUnknown = 1e9;
  std::array<double, 128> known_; // trim by MIDI note
  std::size_t note_ = 0;
  double pole_ = 0, loudness_ = 0, power_pole_ = 0, trim_ = 0;
  int place_ = 0;
};

} // namespace tactus::reed
