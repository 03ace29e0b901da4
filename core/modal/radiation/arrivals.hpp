#pragma once

#include "core/modal/radiation/band_limit.hpp"
#include "core/modal/radiation/delay_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// The sound's travel time along the shortest path, split between the delay line and the kernels.
///
/// The latency of BandLimit is subtracted, down to 0. The delay line takes `delay_s`; the kernels
/// of a near listener hold the remaining fraction of a sample, because the response of a short
/// delay line is flat for whole delays only. `from_s`: another delay that this one exceeds by whole
/// samples; below 0: none.
struct TravelTime {
  double delay_s = 0, fractional_samples = 0;
  TravelTime() = default;
  TravelTime(double travel_s, double sample_rate, double from_s = -1) {
    const double samples =
        std::max(travel_s * sample_rate - static_cast<double>(BandLimit::kLatency), 0.0);
    const double from = from_s * sample_rate;
    double delay = samples < static_cast<double>(DelayLine::kHalf) ? std::floor(samples) : samples;
    if (from >= 0 && samples >= from)
      delay = from + std::floor(samples - from);
    delay_s = delay / sample_rate;
    fractional_samples = samples - delay;
  }
};

/// The impulse responses from a body's motions to the sound pressure at a listener.
///
/// Each response is the pressure for a unit impulse of one motion's acceleration, band-limited by
/// BandLimit (and late by BandLimit::kLatency), without the delay of the shortest path. The motions
/// are the table's modes, then the six rigid motions of a free body.
class Arrivals {
public:
  static constexpr std::size_t kRigid = 6;
  /// The longest response in samples; later arrivals are moved to its end. Paths differ by more
  /// only in bodies larger than 7 m (at 48 kHz).
  static constexpr std::size_t kMaxSpread = 1024;

  virtual ~Arrivals() = default;
  double delay_s = 0;  ///< delay of the delay line
  bool silent = false; ///< no face of the body is turned to the listener
  /// The number of modes; the rigid motions come after them.
  [[nodiscard]] virtual std::size_t modes() const noexcept = 0;
  /// The length of the responses in samples.
  [[nodiscard]] virtual std::size_t samples() const noexcept = 0;
  /// Writes [samples()][BandLimit::kNodes] pressures in Pa for an impulse of 1/sample of the
  /// acceleration of `motion` at time 0.
  virtual void find(std::size_t motion, std::span<double> pressure) const = 0;
};

} // namespace tactus::modal
