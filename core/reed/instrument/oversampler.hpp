#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/instrument/halfband.hpp"

#include <array>
#include <cstddef>

namespace tactus::reed {

/// Samples of a reed's outputs: radiated pressure at 1 m (Pa; of the first lane), theta (rad), p_b
/// (Pa), U (m^3/s).
template <class V> struct ReedOutputs {
  double* radiated;
  V* angle;
  V* bore_pressure;
  V* flow;
};

/// Computes samples of the host from internal samples: the mouth pressure is interpolated linearly,
/// the outputs are decimated by half-band filters. V is that of ReedBank.
template <class V, int max_count> class Oversampler {
public:
  /// The last mouth pressure, Pa.
  [[nodiscard]] const V& mouth_pressure() const noexcept { return mouth_pressure_; }
  void set_mouth_pressure(const V& pressure) noexcept { mouth_pressure_ = pressure; }
  /// Clears the filters.
  void reset() noexcept {
    radiated_.reset();
    for (auto& decimator : decimators_)
      decimator.reset();
  }

  /// Computes count samples, of at most max_count internal samples in all, by
  /// advance(mouth pressures, outputs, internal samples). factor: 1, 2 or 4.
  template <class Advance>
  void run(int factor, const V* mouth_pressure, const ReedOutputs<V>& out, int count,
           Advance&& advance) noexcept {
    if (factor == 1) {
      mouth_pressure_ = mouth_pressure[count - 1];
      return advance(mouth_pressure, out, count);
    }
    using Signal = std::array<V, max_count>;
    Signal mouth{}, angle, bore, flow;
    std::array<double, max_count> radiated;
    const V share(1.0 / factor);
    std::size_t at = 0;
    for (int n = 0; n < count; ++n) {
      const V before = n > 0 ? mouth_pressure[n - 1] : mouth_pressure_;
      const V rise = share * (mouth_pressure[n] - before);
      for (int k = 1; k < factor; ++k)
        mouth[at++] = before + V(static_cast<double>(k)) * rise;
      mouth[at++] = mouth_pressure[n];
    }
    mouth_pressure_ = mouth_pressure[count - 1];
    advance(mouth.data(), ReedOutputs<V>{radiated.data(), angle.data(), bore.data(), flow.data()},
            count * factor);
    radiated_.run(factor, radiated.data(), out.radiated, count);
    decimators_[0].run(factor, angle.data(), out.angle, count);
    decimators_[1].run(factor, bore.data(), out.bore_pressure, count);
    decimators_[2].run(factor, flow.data(), out.flow, count);
  }

private:
  V mouth_pressure_{0.0};
  Decimator<double, max_count> radiated_{};
  std::array<Decimator<V, max_count>, 3> decimators_{};
};

} // namespace tactus::reed
