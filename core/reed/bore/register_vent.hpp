#pragma once

#include "core/dsp/simd.hpp"
#include "core/reed/bore/bore_design.hpp"
#include "core/reed/bore/round_trip_filter.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <algorithm>
#include <complex>

namespace tactus::reed {

/// The register vent (speaker hole): a narrow side hole in the line, near the reed. Through its
/// air, of mass M and friction R (chimney and end corrections; friction at kFriction Hz), flows U,
///   M U' + R U + N U|U| = p,   N = kSeparation rho/(2 A^2),
/// for the jet that leaves it loses its kinetic energy: loud, the vent takes more from the
/// register that has its largest pressure there than its friction does. The waves a and b that
/// arrive at it from above and below have the pressure p = a + b - q there, q = Z_0 U/2, Z_0 =
/// rho c/S of the bore there, in a cone too; b - q goes up, a - q down. Partly open it lets out a
/// share g of q: no power is gained for any g in 0..1. For small waves
///   q/(a + b) = H(s) = Z_0/(Z_0 + 2 (R + s M)) = share/(1 + s/corner).
struct RegisterVent {
  static constexpr double kFriction = 600, kSeparation = 1.5;

  double position = 0; // m, from the reed's end of the line
  double share = 0;    // H(0); 0: there is none
  double corner = 1;
  double separation = 0; // 4 N/Z_0^2 of q, times share: 1/Pa

  /// Of the instrument that the parameters' bore ends in.
  [[nodiscard]] static RegisterVent of(const Parameters& parameters) noexcept;
  [[nodiscard]] std::complex<double> at(std::complex<double> s) const noexcept {
    return share / (1.0 + s / corner);
  }
  /// The round trip that a line without vent would have, for the same reflection below it, where
  /// `round_trip` is that of the line with it: `way` is what the way to the vent and back takes of
  /// a wave. Small waves.
  [[nodiscard]] std::complex<double> without_vent(std::complex<double> s,
                                                  std::complex<double> round_trip,
                                                  std::complex<double> vent_path) const noexcept {
    const std::complex<double> h = at(s), at_reed = round_trip / vent_path,
                               below = (at_reed + h) / (1.0 - h);
    return vent_path * below / (1.0 - h * (1.0 + below));
  }
};

/// The vent where two stretches of line meet. With q in place of U its equation is
///   q'/corner + q + separation q|q| = share (a + b),
/// one backward Euler step a sample in closed form.
template <class V> class VentFilter {
public:
  void set(const RegisterVent& vent, double rate) noexcept {
    mass_ = V(rate / vent.corner);
    resistance_ = V(1 + rate / vent.corner);
    share_ = V(vent.share);
    separation_ = V(4 * vent.separation);
  }
  void reset() noexcept { q_ = V(0.0); }
  template <class Change> void each(Change change) noexcept { change(q_); }

  /// above: what arrives from the reed becomes what goes back to it; below: what arrives from below
  /// becomes what goes down. open: at the first sample, and what each adds.
  template <class Losses>
  void pass(Losses& losses, V* above, V* below, double open, double step, int count) noexcept {
    V q = q_;
    for (int i = 0; i < count; ++i) {
      const V a = losses.incident(above[i]), b = below[i];
      const V source = share_ * (a + b) + mass_ * q;
      const V root =
          simd::square_root(resistance_ * resistance_ + separation_ * simd::absolute(source));
      q = V(2.0) * source / (resistance_ + root);
      const V out = V(open + step * i) * q;
      above[i] = b - out;
      below[i] = a - out;
    }
    q_ = q;
  }

private:
  V mass_{0.0}, resistance_{1.0}, share_{0.0}, separation_{0.0}, q_{0.0};
};

} // namespace tactus::reed
