#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace tactus::particle {

/// A mode of what the grains strike, or of the grains themselves when they ring alike.
struct RingingMode {
  double frequency_hz = 1000;
  double t60_s = 0.1; ///< in which it falls by 60 dB
  double gain = 1;    ///< square root of the ring's energy for a collision of strength 1
};

/// A container, or coins and jingles, that every collision strikes: each mode answers an impulse of
/// strength s with s g sqrt(4 d (w^2 + d^2)) / w exp(-d t) sin(w t), d = 6.908 / t60, whose energy
/// (integral of the square over time) is (s g)^2 at any frequency, decay and sample rate. Strengths
/// are those of particle::Grain. Poles are exact; modes above 0.45 of the sample rate stay silent.
class RingingBody {
public:
  static constexpr std::size_t kMaxModes = 16;

  /// Another sample rate silences the body.
  void prepare(double sample_rate) noexcept;
  /// The first kMaxModes of these; what rings goes on at the new frequencies, and modes that are no
  /// longer listed ring out.
  void set(std::span<const RingingMode> modes) noexcept;
  void reset() noexcept;
  /// One sample after an impulse of that strength.
  double next(double strength) noexcept;
  [[nodiscard]] bool at_rest() const noexcept { return at_rest_; }
  [[nodiscard]] std::span<const RingingMode> modes() const noexcept {
    return std::span(modes_).first(count_);
  }

private:
  static constexpr int kCheckInterval = 64; ///< samples between two looks for silence
  static constexpr double kSilence = 1e-10; ///< amplitude, -200 dB of full scale
  void update() noexcept;

  double sample_rate_ = 48000;
  std::size_t count_ = 0, used_ = 0; ///< modes listed; slots that may still ring
  bool at_rest_ = true;
  int until_check_ = kCheckInterval;
  std::array<RingingMode, kMaxModes> modes_{};
  std::array<double, kMaxModes> onset_{}; ///< amplitude for strength 1
  std::array<double, kMaxModes> pole_real_{}, pole_imaginary_{};
  std::array<double, kMaxModes> real_{}, imaginary_{}; ///< of a exp(-d t + j w t)
};

} // namespace tactus::particle
