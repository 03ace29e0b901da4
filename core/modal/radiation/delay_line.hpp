#pragma once

#include "core/modal/bank/glide.hpp"

#include <array>
#include <cstddef>
#include <vector>

namespace tactus::modal {

/// The sound's travel time: a delay of any fraction of a sample, without latency beyond it.
///
/// A sample between two others is the sum over 40 neighbours of sinc(t) under Kaiser's window
/// (beta 5.5), its gain at 0 Hz made 1: flat within 0.03 dB and true within a thousandth of a
/// sample up to 0.4535 of the sample rate (20 kHz at 44.1 kHz). A delay shorter than 20 samples has
/// fewer neighbours on one side and takes as many on both: within 0.25 dB at a quarter of the
/// sample rate from two samples on, but no longer flat to the top. Whole delays are exact, so a
/// resting listener that near has its fraction of a sample in what it is given (TravelTime).
///
/// A new delay takes over as Glide has it: in a cross-fade of up to three delays, or as one delay
/// that moves and bends the pitch as a moving listener hears it, no faster than kMaxSlope.
class DelayLine {
public:
  static constexpr std::size_t kHalf = 20;   ///< neighbours on each side
  static constexpr double kMaxSlope = 0.125; ///< samples a sample: 43 m/s

  /// Allocates; keeps nothing of before.
  void prepare(std::size_t longest);
  /// `glide`: bends the pitch, else cross-fades; holds from the next rest on. `jump`: at once.
  void set(double samples, bool glide, bool jump) noexcept;
  void clear() noexcept;

  [[nodiscard]] float step(float in) noexcept {
    run(&in, 1);
    return in;
  }
  /// The same for many samples, in place; the same bits however they are cut.
  void run(float* sound, std::size_t count) noexcept;

private:
  static constexpr std::size_t kChunk = 64;                      ///< samples worked together
  static constexpr std::size_t kMargin = kChunk + 2 * kHalf + 2; ///< beyond the longest delay

  /// Weights of the samples whole - half + 1 ... whole + half before the present one.
  struct Kernel {
    std::array<float, 2 * kHalf> weight{1};
    std::size_t newest = 0, count = 1; ///< of the samples: age of the newest, and how many
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
  double target_ = 0;                      ///< samples
  double target_sum_ = 0, target_age_ = 0; ///< over the samples of the segment, for its mean
  Value old_, middle_, latest_;
  Glide glide_;
  bool doppler_ = false;
};

} // namespace tactus::modal
