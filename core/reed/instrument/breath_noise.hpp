#pragma once

#include "core/dsp/random.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <type_traits>

namespace tactus::reed {

/// Noise of the breath: a random share of the jet's pressure, with the same power in each hertz at
/// any rate. V is that of ReedBank; all lanes have the same noise.
template <class V, int max_count> class BreathNoise {
public:
  void seed(unsigned value) noexcept { random_.seed(value); }

  struct Breath {
    const V* mouth_pressure;
    const double* noise; ///< noise of the jet, relative; null: none
  };
  /// The breath of the next count internal samples at this rate, Hz. `share`:
  /// Parameters::breath_noise.
  [[nodiscard]] Breath draw(const V* mouth_pressure, double share, double rate,
                            int count) noexcept {
    const double strength = share * std::sqrt(rate / 48e3);
    if (share > kFaint) { // limited to the pressure that drives the jet
      for (int i = 0; i < count; ++i)
        noise_[static_cast<std::size_t>(i)] = std::clamp(strength * random_.normal(), -0.9, 0.9);
      return {mouth_pressure, noise_.data()};
    }
    if (!(strength > 0))
      return {mouth_pressure, nullptr};
    const double amplitude = strength * std::numbers::sqrt3;
    for (int i = 0; i < count; ++i)
      breath_[static_cast<std::size_t>(i)] =
          mouth_pressure[i] * V(1 + amplitude * (2 * random_.uniform() - 1));
    return {breath_.data(), nullptr};
  }

private:
  /// Up to this level noise is uniform and a share of the mouth pressure, which costs a fraction of
  /// the jet's own noise. It does not stop while the valve is shut, which is inaudible at this
  /// level.
  static constexpr double kFaint = std::is_same_v<V, double> ? 1e-5 : 1e-3;

  Random random_{};
  std::array<double, max_count> noise_{};
  std::array<V, max_count> breath_{};
};

} // namespace tactus::reed
