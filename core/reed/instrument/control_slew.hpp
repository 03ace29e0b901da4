#pragma once

#include "core/dsp/elementary.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// The low-pass of reed frequency and length, stepped once per control period. V is that of
/// ReedBank.
template <class V> class ControlSlew {
public:
  void prepare(double sample_rate) noexcept {
    gain_ = 1 - math::exp(-kControlPeriod / (kTime * sample_rate));
    max_immediate_step_ = kMaxImmediateRate * kControlPeriod / sample_rate;
  }
  /// Gain of the one-pole low-pass.
  [[nodiscard]] double gain() const noexcept { return gain_; }
  /// The step of a number of the given size towards a target at the given difference: a one-pole
  /// low-pass of kTime. If a player moves the number (`played`), motion below kMaxImmediateRate is
  /// followed at once, so that glides and vibrato have no delay; only the rest of a leap is
  /// low-passed.
  [[nodiscard]] V step(const V& difference, const V& size, bool played) const noexcept {
    const V part = V(gain_) * difference;
    if (!played)
      return part;
    const V room =
        simd::minimum(simd::absolute(difference), V(max_immediate_step_) * simd::absolute(size));
    return simd::copy_sign(simd::maximum(simd::absolute(part), room), difference);
  }

private:
  static constexpr double kTime = 5e-3; // s
  /// 1/s: a control that moves by less than an octave in 30 ms is followed without delay.
  static constexpr double kMaxImmediateRate = 25;
  double gain_ = 1, max_immediate_step_ = 0;
};

} // namespace tactus::reed
