#pragma once

#include "core/modal/bank/glide.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace tactus::modal {

/// A variable fractional delay line for the sound's travel time to a listener.
///
/// Interpolation: 40 neighbours weighted by a sinc under a Kaiser window (beta 5.5), normalised to
/// gain 1 at 0 Hz. Its response is flat within 0.03 dB, and its delay is exact within 0.001
/// samples, up to 0.4535 of the sample rate (20 kHz at 44.1 kHz). A delay below 20 samples has
/// fewer newer neighbours and uses as few older ones. From a delay of two samples on, the response
/// is within 0.25 dB at a quarter of the sample rate, but falls above it. Whole delays are exact;
/// the kernels of a near listener hold the fraction (TravelTime).
///
/// A new delay is reached as Glide describes: by a cross-fade of up to three delays, or by one
/// moving delay, whose Doppler shift is limited by kMaxSlope.
class DelayLine {
public:
  static constexpr std::size_t kHalf = 20;   ///< neighbours on each side
  static constexpr double kMaxSlope = 0.125; ///< samples per sample: 43 m/s

  /// Allocates and clears. `longest`: the longest delay in samples.
  void prepare(std::size_t longest);
  /// Sets the delay in samples. `glide`: a moving delay with Doppler shift, else a cross-fade; a
  /// change of `glide` takes effect at the next rest. `jump`: sets the delay at once.
  void set(double samples, bool glide, bool jump) noexcept;
  void clear() noexcept;

  [[nodiscard]] float step(float in) noexcept {
    run(&in, 1);
    return in;
  }
  /// Delays `count` samples in place; gives the same bits in blocks of any size.
  void run(float* sound, std::size_t count) noexcept;

private:
  static constexpr std::size_t kChunk = 64;                      ///< samples computed together
  static constexpr std::size_t kMargin = kChunk + 2 * kHalf + 2; ///< samples beyond the longest
                                                                 ///< delay

  /// Interpolation weights of the samples around the delay.
  struct Kernel {
    std::array<float, 2 * kHalf> weight{1};
    std::size_t newest = 0, count = 1; ///< age of the newest sample, number of samples
    explicit Kernel(double delay = 0) noexcept;
  };
  struct Value {
    double delay = 0;
    Kernel kernel;
  };
  [[nodiscard]] Value limited(double target) const noexcept;
  void exchange(Glide::Exchange exchange, bool had_target) noexcept;
  void run_chunk(float* sound, std::size_t count) noexcept;
  void read(const Kernel& kernel, std::size_t first, float* out, std::size_t count) const noexcept;

  std::vector<float> line_ = std::vector<float>(256, 0.0F);
  std::size_t mask_ = 255, write_ = 0;
  double target_ = 0; ///< samples
  double target_sum_ = 0,
         target_age_ = 0; ///< sum of targets in the segment and its age, for their mean
  Value old_, middle_, latest_;
  Glide glide_;
  bool doppler_ = false;
};

} // namespace tactus::modal
