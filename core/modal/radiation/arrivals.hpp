#pragma once

#include "core/modal/radiation/band_limit.hpp"
#include "core/modal/radiation/delay_line.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <span>
#include <vector>

namespace tactus::modal {

/// The time of the shortest path, less BandLimit's latency and never below 0, in two parts: what a
/// delay line takes, and the fraction of a sample that a near listener's kernels hold, because the
/// line is flat for whole delays only when they are short. `from_s`: a shorter delay that this one
/// shall exceed by whole samples; below 0: none.
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

/// What a listener receives of a body's motions: the pressure for a unit impulse of each motion's
/// acceleration, band-limited by BandLimit and BandLimit::kLatency late, with the delay of the
/// shortest path taken out. Motions are the table's modes, then a free body's six rigid motions.
class Arrivals {
public:
  static constexpr std::size_t kRigid = 6;
  /// Later arrivals are counted as if they came then: the paths of a body of more than 7 m differ
  /// by more (48 kHz).
  static constexpr std::size_t kMaxSpread = 1024;

  virtual ~Arrivals() = default;
  double delay_s = 0;  ///< left for a delay line
  bool silent = false; ///< the listener sees nothing of the body
  /// Of the table; a free body's rigid motions come after them.
  [[nodiscard]] virtual std::size_t modes() const noexcept = 0;
  /// Samples within which everything arrives.
  [[nodiscard]] virtual std::size_t samples() const noexcept = 0;
  /// Pressure [samples()][BandLimit::kNodes] in Pa for an acceleration impulse of the motion at
  /// time 0, 1/sample.
  virtual void find(std::size_t motion, std::span<double> pressure) const = 0;
};

} // namespace tactus::modal
