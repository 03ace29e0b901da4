#pragma once

#include "core/contact/impact.hpp"

#include <complex>
#include <cstddef>
#include <cstdint>
#include <span>

namespace tactus::modal {

/// A blow in closed form: a half sine of force, F(t) = J pi/(2 T) sin(pi t/T), 0 <= t <= T.
struct Pulse {
  double impulse_n_s = 0, duration_s = 0;
  double mass_ratio = 0; ///< m M: striker's mass over that of what gives way

  /// Up to here the impulse is within 0.5 dB of the coupled blow's; a striker that is heavier stays
  /// while the body comes back to it, and touches it again.
  static constexpr double kMaxMassRatio = 0.4;

  /// Spectrum over that at 0 Hz: cos(omega T/2) / (1 - (omega T/pi)^2).
  [[nodiscard]] static double spectrum(double radians) noexcept; ///< of omega T
  /// What its size never exceeds, without a cosine: 1, and 1/((omega T/pi)^2 - 1) where that is
  /// less.
  [[nodiscard]] static double envelope(double radians) noexcept {
    constexpr double kInverse = 0.3183098861837907; // 1/pi
    const double square = radians * radians * (kInverse * kInverse);
    return square > 2 ? 1 / (square - 1) : 1;
  }
};

/// What a blow meets at its place.
struct StruckPoint {
  std::span<const double> gain;               ///< b of all modes, 1/sqrt(kg)
  std::span<const std::complex<double>> rate; ///< s of all modes, 1/s
  double rigid_mobility_per_kg = 0;           ///< sum of b^2 of a free body's rigid motions
  double compliance_m_per_n = 0;              ///< of the modes that the table leaves out
  std::span<const std::uint8_t> band{};       ///< pulse_band() of each; empty: not worked out yet
};

/// Which of 128 bands, four an octave, a mode is in: a strike cannot tell neighbours apart, and the
/// search for its duration does not grow with the body.
[[nodiscard]] std::uint8_t pulse_band(double omega_per_s) noexcept;
inline constexpr std::size_t kPulseBands = 128;
/// The band's lowest frequency, 1/s.
[[nodiscard]] double pulse_band_begin(std::size_t band) noexcept;

/// The half sine nearest to the coupled blow of a striker on a body at rest.
///
/// Impulse: a force of spectrum S (1 at 0 Hz) leaves J^2 M/2 in the body, M = sum of the rigid
/// b^2 + sum of the modes' b^2 S(omega)^2; energy and momentum then give
///   J = (1 + e) v / (1/m + M),
/// Newton's restitution e of the contact itself, Zener's loss to waves (1941) in M.
/// Duration: that of a mass 1/(1/m + M) on the contact's law in series with the compliance of what
/// swings faster than the pulse, half the modes' b^2/omega^2 where omega T = pi; both are found
/// together. Valid for a single contact (kMaxMassRatio).
[[nodiscard]] Pulse find_pulse(const contact::ImpactLaw& law, double striker_mass_kg,
                               double speed_m_per_s, double restitution,
                               const StruckPoint& point) noexcept;

} // namespace tactus::modal
