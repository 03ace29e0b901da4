#pragma once

#include "core/dsp/elementary.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

namespace tactus::modal {

/// The low-pass kernel that samples impulses at arbitrary times without aliasing.
///
/// A sinc under a Kaiser window (Kaiser 1974), time in samples. Its passband is flat within 0.003
/// dB up to 20 kHz, or 0.4535 of lower sample rates. Aliases below that frequency are 100 dB down;
/// at sample rates below 47 kHz, where the transition band is narrower, 72 dB.
struct BandLimit {
  static constexpr std::size_t kHalfWidth = 24;
  /// Latency in samples, which makes the kernel causal and leaves room for the interpolation below.
  static constexpr std::size_t kLatency = kHalfWidth + 1;

  /// Times within a sample at which signals are evaluated: its beginning, and the four nodes of
  /// Gauss-Legendre quadrature for integrals over it.
  static constexpr std::size_t kNodes = 5, kGauss = 4;
  static constexpr std::array<double, kNodes> kNode{0, 0.06943184420297371, 0.33000947820757187,
                                                    0.6699905217924281, 0.9305681557970263};
  static constexpr std::array<double, kGauss> kGaussWeight{
      0.17392742256872692, 0.32607257743127307, 0.32607257743127307, 0.17392742256872692};

  /// Delays are distributed to bins of 1/8 sample by cubic interpolation (error below 0.002 dB).
  static constexpr std::size_t kBins = 8, kSpan = 4;
  /// The length of one bin's response in samples.
  static constexpr std::size_t kLength = 2 * kLatency + 1;

  /// Responses [bin][kLength][kNodes] to an impulse in one bin of a sample, delayed by kLatency;
  /// bin 1 is the sample's beginning.
  std::array<std::array<double, kLength * kNodes>, kBins> response;

  [[nodiscard]] static const BandLimit& at_rate(double sample_rate) {
    static const BandLimit narrow(7.0), wide(10.06);
    return sample_rate < 47000 ? narrow : wide;
  }
  [[nodiscard]] double kernel(double t) const noexcept {
    const double x = t / static_cast<double>(kHalfWidth);
    if (!(std::abs(x) < 1))
      return 0;
    const double phase = std::numbers::pi * t;
    const double sinc = std::abs(phase) < 1e-9 ? 1 : math::sin(phase) / phase;
    return sinc * math::bessel_i0(beta_ * std::sqrt(1 - x * x)) / math::bessel_i0(beta_);
  }

private:
  explicit BandLimit(double beta) : beta_(beta) {
    for (std::size_t r = 0; r < kBins; ++r)
      for (std::size_t n = 0; n < kLength; ++n)
        for (std::size_t m = 0; m < kNodes; ++m)
          response[r][n * kNodes + m] =
              kernel(static_cast<double>(n) + kNode[m] -
                     (static_cast<double>(r) - 1) / static_cast<double>(kBins) -
                     static_cast<double>(kLatency));
  }
  double beta_; ///< shape parameter of Kaiser's window
};

} // namespace tactus::modal
