#pragma once

#include <array>

namespace tactus::haptic {

/// Anti-aliasing low-pass before an audio signal is sampled at the servo's rate: Butterworth of
/// eighth order, four second-order sections by the bilinear transform. -3 dB at the cut-off, -48 dB
/// at twice the cut-off; the group delay at low frequencies is 5.13/(2 pi cut-off).
class Decimator {
public:
  static constexpr double kCutoffRatio = 0.4; ///< cut-off over the servo's rate; Nyquist is 0.5

  /// Rates in Hz, positive and finite. With a cut-off of 0.45 of the sample rate or more the filter
  /// is bypassed.
  void set(double sample_rate_hz, double servo_rate_hz) noexcept;
  void reset() noexcept;
  /// Filters one sample. An input that is not finite, or beyond 1e9, counts as 0.
  [[nodiscard]] double process(double input) noexcept;

private:
  struct Section {
    double b = 0, a1 = 0, a2 = 0; // b (1 + 2/z + 1/z^2) / (1 + a1/z + a2/z^2)
    double s1 = 0, s2 = 0;
  };
  std::array<Section, 4> sections_{};
  bool bypass_ = true;
};

} // namespace tactus::haptic
