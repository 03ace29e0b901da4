#pragma once

#include <array>

namespace tactus::haptic {

/// Keeps of an audio signal what a servo's rate can carry: a Butterworth low-pass of the eighth
/// order, four second-order sections by the bilinear transform. At the cut-off -3 dB, at twice the
/// cut-off -48 dB; the delay of low frequencies is 5.13/(2 pi cut-off).
class Decimator {
public:
  static constexpr double kCutoffRatio = 0.4; ///< cut-off over the servo's rate; its Nyquist is 0.5

  /// Positive and finite rates; a cut-off above 0.45 of the sample rate passes everything.
  void set(double sample_rate_hz, double servo_rate_hz) noexcept;
  void reset() noexcept;
  /// What is not finite counts as 0.
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
