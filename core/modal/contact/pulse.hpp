#pragma once

#include "core/contact/impact.hpp"
#include "core/dsp/complex.hpp"

#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus::modal {

/// A strike in closed form: a half-sine pulse of force, F(t) = J pi/(2 T) sin(pi t/T), 0 <= t <= T,
/// with the impulse J in N s and the duration T in s.
struct Pulse {
  double impulse_n_s = 0, duration_s = 0;
  double mass_ratio = 0; ///< m M: striker's mass times the body's mobility M

  /// Up to this ratio the impulse is within 0.5 dB of that of the coupled contact. A heavier
  /// striker is still within reach when the body swings back and hits it again.
  static constexpr double kMaxMassRatio = 0.4;

  /// The pulse's spectrum over its value at 0 Hz: cos(omega T/2) / (1 - (omega T/pi)^2), `radians`
  /// is omega T.
  [[nodiscard]] static double spectrum(double radians) noexcept;
  /// An upper bound of |spectrum| without a cosine: 1, or 1/((omega T/pi)^2 - 1) if that is less.
  [[nodiscard]] static double envelope(double radians) noexcept {
    constexpr double kInverse = 0.3183098861837907; // 1/pi
    const double square = radians * radians * (kInverse * kInverse);
    return square > 2 ? 1 / (square - 1) : 1;
  }
};

/// The body at the point where it is struck.
struct StruckPoint {
  std::span<const double> gain;         ///< b of all modes, 1/sqrt(kg)
  std::span<const Complex> rate;        ///< s of all modes, 1/s
  double rigid_mobility_per_kg = 0;     ///< sum of b^2 of a free body's rigid motions
  double compliance_m_per_n = 0;        ///< compliance of the modes that the table omits
  std::span<const std::uint8_t> band{}; ///< pulse_band() of each mode; empty: computed here
};

/// The band of an angular frequency: one of 128 bands, four to the octave. Summing modes by bands
/// keeps the search for a pulse's duration from growing with the body.
[[nodiscard]] std::uint8_t pulse_band(double omega_per_s) noexcept;
inline constexpr std::size_t kPulseBands = 128;
/// The band's lowest frequency, 1/s.
[[nodiscard]] double pulse_band_begin(std::size_t band) noexcept;

/// The half-sine pulse that approximates the coupled strike of a striker on a body at rest.
///
/// Impulse: a pulse of spectrum S (1 at 0 Hz) leaves the energy J^2 M/2 in the body, where
/// M = sum of the rigid b^2 + sum of the modes' b^2 S(omega)^2. Energy and momentum then give
///   J = (1 + e) v / (1/m + M).
/// e is Newton's restitution of the contact itself; the loss to waves (Zener 1941) is in M.
/// Duration: that of a mass 1/(1/m + M) on the contact law in series with the compliance of the
/// modes that are faster than the pulse, C = sum of b^2/omega^2 x^2/(1 + x^2), x = omega T/pi. J
/// and T are iterated together. Valid for a single contact: see kMaxMassRatio.
[[nodiscard]] Pulse find_pulse(const contact::ImpactLaw& law, double striker_mass_kg,
                               double speed_m_per_s, double restitution,
                               const StruckPoint& point) noexcept;

} // namespace tactus::modal
