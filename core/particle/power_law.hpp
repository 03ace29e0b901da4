#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/random.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::particle {

/// Random energies of crumpling events, relative to the smallest: density ~ e^-(exponent + 1) on
/// [1, largest] (Fontana & Bresin 2003). Houle & Sethna 1996 measure exponents of 0.3 to 0.6 for
/// crumpled paper.
class PowerLaw {
public:
  PowerLaw() { set(1.5, 100); }

  /// exponent is clamped to 0.05..20, largest to 1.001..1e9.
  void set(double exponent, double largest) noexcept {
    exponent_ = std::clamp(exponent, 0.05, 20.0);
    largest_ = std::clamp(largest, 1.001, 1e9);
    truncated_mass_ = 1 - math::pow(largest_, -exponent_);
  }

  /// An energy, by inversion of the distribution function.
  [[nodiscard]] double draw(Random& random) const noexcept {
    return std::min(math::pow(1 - random.uniform() * truncated_mass_, -1 / exponent_), largest_);
  }

  /// Expectation of the energy.
  [[nodiscard]] double mean() const noexcept {
    if (std::abs(exponent_ - 1) < 1e-9)
      return math::log(largest_) / truncated_mass_;
    return exponent_ / truncated_mass_ * (1 - math::pow(largest_, 1 - exponent_)) / (exponent_ - 1);
  }

private:
  double exponent_, largest_;
  double truncated_mass_; ///< probability below `largest` of the law without an upper limit
};

} // namespace tactus::particle
