#pragma once

#include "core/dsp/complex.hpp"
#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <algorithm>

namespace tactus::reed {

/// The register vent (speaker hole) of a woodwind: a narrow side hole near the reed that weakens
/// the lower register, so that the instrument overblows.
///
/// The flow U (m^3/s) through the hole follows from the pressure p (Pa) in the bore,
///   M U' + R U + N U|U| = p,   N = kSeparation rho/(2 A^2),
/// where M is the inertance of the hole's air (kg/m^4; chimney and end corrections), R the hole's
/// friction at kFrictionFrequency_hz (Pa s/m^3), A its cross-section (m^2). The last term is the
/// kinetic energy lost by the jet that leaves the hole; at large amplitudes it exceeds the
/// friction.
///
/// Waves a and b (Pa) arrive from above and below. With q = Z_0 U/2, Z_0 = rho c/S of the bore at
/// the hole (also in a cone), p = a + b - q; b - q travels up, a - q down. A vent that is partly
/// open lets out a share g of q, which gains no power for any g in 0..1. For small waves
///   q/(a + b) = H(s) = Z_0/(Z_0 + 2 (R + s M)) = share/(1 + s/corner).
/// Limit: R is taken at one frequency (docs/theory/bores.md, Validity).
struct RegisterVent {
  static constexpr double kFrictionFrequency_hz = 600;
  static constexpr double kSeparation = 1.5;

  double position = 0;   // m, from the reed's end of the line
  double share = 0;      // H(0); 0: there is no vent
  double corner = 1;     // corner frequency of H, rad/s
  double separation = 0; // factor of q|q|: 4 N/Z_0^2 times share, 1/Pa

  /// The vent of the instrument Parameters::end; share 0 if the instrument has none.
  [[nodiscard]] static RegisterVent of(const Parameters& parameters) noexcept;
  /// H(s), s in rad/s.
  [[nodiscard]] Complex at(Complex s) const noexcept { return share / (1.0 + s / corner); }
  /// Converts the round trip of the line with its vent to that of the line without it, for the same
  /// reflection below the vent. vent_path: the factor of the path from the reed to the vent and
  /// back. For small waves.
  [[nodiscard]] Complex without_vent(Complex s, Complex round_trip,
                                     Complex vent_path) const noexcept {
    const Complex h = at(s), at_reed = round_trip / vent_path, below = (at_reed + h) / (1.0 - h);
    return vent_path * below / (1.0 - h * (1.0 + below));
  }
};

/// The scattering junction at a RegisterVent, where two parts of the delay line meet:
///   q'/corner + q + separation q|q| = share (a + b),
/// by one backward Euler step per sample, solved in closed form. V is double or simd::Lanes.
template <class V> class VentFilter {
public:
  /// sample_rate: in Hz.
  void set(const RegisterVent& vent, double sample_rate) noexcept {
    mass_ = V(sample_rate / vent.corner);
    resistance_ = V(1 + sample_rate / vent.corner);
    share_ = V(vent.share);
    separation_ = V(4 * vent.separation);
  }
  void reset() noexcept { q_ = V(0.0); }
  template <class Change> void each(Change change) noexcept { change(q_); }

  /// Opening g (0..1) at the first sample, and its increment per sample.
  struct Opening {
    double start, step;
  };
  /// Scatters count samples in place. above: the wave from the reed is replaced by the wave back to
  /// the reed. below: the wave from below is replaced by the wave that goes down. losses:
  /// RoundTripFilter of the part above.
  template <class Losses>
  void pass(Losses& losses, V* above, V* below, const Opening& open, int count) noexcept {
    V q = q_;
    for (int i = 0; i < count; ++i) {
      const V a = losses.incident(above[i]), b = below[i];
      const V source = share_ * (a + b) + mass_ * q;
      const V root =
          simd::square_root(resistance_ * resistance_ + separation_ * simd::absolute(source));
      q = V(2.0) * source / (resistance_ + root);
      const V out = V(open.start + open.step * i) * q;
      above[i] = b - out;
      below[i] = a - out;
    }
    q_ = q;
  }

private:
  V mass_{0.0}, resistance_{1.0}, share_{0.0}, separation_{0.0}, q_{0.0};
};

} // namespace tactus::reed
