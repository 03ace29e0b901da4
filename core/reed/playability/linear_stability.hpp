#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/instrument/parameters.hpp"

namespace tactus::reed {

/// One mode of the linearised instrument, growing or decaying as exp(growth_rate t).
struct Mode {
  double growth_rate = 0;  // Re s, 1/s; > 0 starts by itself
  double frequency_hz = 0; // Im s / 2 pi
  bool found = false;      // Newton's iteration converged
};

/// Static state of the valve under a steady mouth pressure.
struct Equilibrium {
  double displacement = 0;  // x_s, m, where the forces balance (may lie beyond a stop)
  double bore_pressure = 0; // Pa; 0 unless the reflection is a scalar below 1
  double jet_velocity = 0;  // u_0, m/s
  double area = 0;          // A_0, m^2
  double flow = 0;          // U_s, m^3/s
  bool free = true;         // false: pressed against its stop or |x_s| > x_max
  double excess = 0;        // distance beyond the stop or limit, relative to |x_0| or x_max
};

/// Pressure at which a mode neither grows nor decays.
struct Threshold {
  double mouth_pressure = 0; // Pa
  double frequency_hz = 0;
  bool found = false;
};

/// Linear stability analysis of an instrument: its modes exp(s t) of small amplitude about the
/// static solution, that is, which notes start, how fast and at what pitch.
///   Y_in(s) = Y_valve(s),
///   Y_in    = (1 - rt)/((1 + rt) Z_0) + 1/(s M) + s C,    rt = R(s) exp(-2 s L/c - G sqrt(s)),
///   Y_valve = -A_0/(rho (|u_0| + s lambda))
///             + (u_0 A_1 + s w lambda_b) w (-lambda_b + sigma mu u_0/(|u_0| + s lambda))/D_v,
///   D_v     = m (w_r^2 + s^2 + s w_r/Q),   A_1 = dA/dx,   sigma = open side of the valve.
/// These are the equations of docs/theory/greed.md, linearised. Limits: no final amplitude, and no
/// hysteresis (a sounding instrument may continue below its threshold).
///
/// A valve pressed against a stop is taken as fixed: only its opening remains, and such a state is
/// silent. No allocation; every search has a fixed limit of steps.
class LinearStability {
public:
  /// length_m > 0 is the bore length L; reed_frequency_hz > 0 is the player's f_r. end: termination
  /// of the bore, which must outlive this object; null: an open end.
  LinearStability(const Parameters& parameters, double length_m,
                  const Termination* end = nullptr) noexcept;

  /// Static state at this mouth pressure, Pa.
  [[nodiscard]] Equilibrium equilibrium(double mouth_pressure,
                                        double reed_frequency_hz) const noexcept;

  /// Y_in, m^3/(Pa s): input admittance of the bore as the valve sees it; s != 0.
  [[nodiscard]] Complex input_admittance(Complex s) const noexcept;
  /// Y_valve, m^3/(Pa s): flow out of the valve per pressure in the bore; s must not be a pole of
  /// it.
  [[nodiscard]] Complex valve_admittance(Complex s, const Equilibrium& state,
                                         double reed_frequency_hz) const noexcept;

  /// The oscillating mode with the largest growth rate, up to twice the reed frequency and at least
  /// the fifth bore mode. Real roots, which do not oscillate, are left out.
  [[nodiscard]] Mode dominant_mode(double mouth_pressure, double reed_frequency_hz) const noexcept;
  /// Newton's iteration from a neutral oscillation of the given frequency.
  [[nodiscard]] Mode mode_near(double mouth_pressure, double reed_frequency_hz,
                               double frequency_hz) const noexcept;

  /// Lowest pressure, to 1e-7 relative, at which the mode near the bore resonance nearest to
  /// frequency_hz turns from decay to growth; frequency_hz = 0: any mode.
  [[nodiscard]] Threshold threshold(double reed_frequency_hz,
                                    double frequency_hz = 0) const noexcept;

  /// Resonance of the bore with its input closed, nearest to a frequency: a root of Y_in.
  [[nodiscard]] Mode bore_resonance_near(double frequency_hz) const noexcept;

  /// Pressure at which the valve closes or reaches its limit, Pa, at most 50 kPa.
  [[nodiscard]] double highest_pressure(double reed_frequency_hz) const noexcept;

private:
  struct Value {
    Complex value, derivative;
  };
  struct Valve;
  [[nodiscard]] Value round_trip(Complex s) const noexcept;
  [[nodiscard]] Value characteristic(Complex s, const Valve& valve) const noexcept;
  [[nodiscard]] Valve valve_at(const Equilibrium& state, double reed_frequency_hz) const noexcept;
  [[nodiscard]] Mode refine(Complex start, const Valve& valve) const noexcept;

  Parameters parameters_;
  Air air_;
  double length_;
  const Termination* end_;
  double characteristic_impedance_; // Z_0
  double inertance_;                // M, 0 for the cylinder
  double compliance_;               // C
  double loss_;                     // G, s^(1/2)
  double direction_;                // sign of theta_0
};

} // namespace tactus::reed
