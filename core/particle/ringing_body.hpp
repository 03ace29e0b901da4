#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace tactus::particle {

/// A mode of the body that the particles strike, or of the particles if all have the same modes.
struct RingingMode {
  double frequency_hz = 1000;
  double t60_s = 0.1; ///< time to decay by 60 dB
  double gain = 1;    ///< g: square root of the sound's energy for a collision of strength 1
};

/// The resonances of a container, or of coins and jingles, that every collision excites.
///
/// The response of a mode to an impulse of strength s (as in particle::Grain) is
///     s g sqrt(4 d (w^2 + d^2)) / w exp(-d t) sin(w t),   d = ln(1000) / t60, w = 2 pi frequency,
/// whose energy (integral of the square over time) is (s g)^2 at any frequency, decay and sample
/// rate. The poles are exact. Modes above 0.45 of the sample rate are not excited.
class RingingBody {
public:
  static constexpr std::size_t kMaxModes = 16;

  /// A new sample rate, Hz, silences the body.
  void prepare(double sample_rate) noexcept;
  /// Sets the modes; those after kMaxModes are ignored. Vibration continues at the new frequencies;
  /// modes that are no longer listed decay.
  void set(std::span<const RingingMode> modes) noexcept;
  void reset() noexcept;
  /// One sample of sound, excited by an impulse of this strength.
  double next(double strength) noexcept;
  [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }
  [[nodiscard]] std::span<const RingingMode> modes() const noexcept {
    return std::span(modes_).first(count_);
  }

private:
  static constexpr int kCheckInterval = 64; ///< samples between two checks for silence
  static constexpr double kSilence = 1e-10; ///< amplitude, -200 dB of full scale
  void update() noexcept;

  double sample_rate_ = 48000;
  std::size_t count_ = 0, used_ = 0; ///< modes listed; modes that may still vibrate
  bool at_rest_ = true;
  int until_check_ = kCheckInterval;
  std::array<RingingMode, kMaxModes> modes_{};
  std::array<double, kMaxModes> onset_{}; ///< amplitude for strength 1
  std::array<double, kMaxModes> pole_real_{}, pole_imaginary_{};
  std::array<double, kMaxModes> real_{}, imaginary_{}; ///< state a exp(-d t + j w t)
};

} // namespace tactus::particle
