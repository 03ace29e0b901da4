#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/bore/air.hpp"
#include "core/reed/bore/open_end.hpp"
#include "core/reed/bore/termination.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <array>

namespace tactus::reed {

/// Delay and filter coefficients of one round trip through the bore: wall loss in parallel
/// first-order sections,
///   incident_gain * (1 + sum_k r_k z^-1/(1 - p_k z^-1)),
/// then the open end. In this form each state is as small as its effect, so that single-precision
/// lanes keep their accuracy.
struct RoundTrip {
  static constexpr int kLossSections = 8; // a power of two
  double delay = 3;                       // D, internal samples, fractional
  std::array<double, kLossSections> loss_pole{}, loss_residue{};
  double incident_gain = 1;
  DigitalOpenEnd end{};

  /// Linear interpolation of the filters, share in 0..1; the delay is that of `to`.
  static RoundTrip interpolate(const RoundTrip& from, const RoundTrip& to, double share) noexcept;
};

/// Designs the filters of a bore from its shape, at one internal sample rate.
///
/// Wall loss: exp(-G sqrt(s)), G from wall_loss(). With sqrt(s) = 1/pi int_0^inf s/(s + q) q^(-1/2)
/// dq, it becomes a product of eight sections. Their frequencies q_k are spaced by a factor e^h
/// from 2 pi 3 to 2 pi min(0.4 fs, 20000) rad/s. Each has a pole at q_k e^(-delta_k/2) and a zero
/// at q_k e^(delta_k/2), delta_k = G h/pi sqrt(q_k) times a weight fitted to attenuation and phase
/// (bore_design.cpp), mapped to exp(pole T) and exp(zero T). Every section has |H| <= 1, so their
/// product has. It is computed as partial fractions (RoundTrip).
///
/// End: an unflanged open end (open_end.hpp); for holes and bells (set_end()) the filters of
/// termination.hpp replace it.
///
/// The delay makes the phase of the whole round trip exact at the ideal lowest resonance. Modes 1
/// to 6 of tubes from 0.3 to 5 m then lie within 1 cent. No allocation.
class BoreDesign {
public:
  /// Range of bore frequencies, Hz; the lowest sets the size of the delay line.
  static constexpr double kLowestFrequency = 8;
  static constexpr double kHighestFrequency = 4000;

  /// Sets air, bore and end without digital filters: enough for all but round_trip() and parts().
  void set_geometry(const Parameters& parameters) noexcept;
  /// As set_geometry(), with filters for this internal sample rate, Hz.
  void set(const Parameters& parameters, double internal_rate) noexcept;
  /// The termination of the bore, which must outlive the design; null: an open end.
  void set_end(const Termination* end) noexcept;
  [[nodiscard]] const Termination* end() const noexcept { return end_; }
  /// Reflectance of the end at s (rad/s), extra length included.
  [[nodiscard]] Complex end_reflection(Complex s) const noexcept;

  /// Filters and delay for a bore of this length, m.
  [[nodiscard]] RoundTrip round_trip(double length) const noexcept;
  /// Losses and delay of the round trip `whole` in two parts: to a position (m from the reed) and
  /// back, and beyond that position.
  struct Parts {
    RoundTrip above{}, below{};
  };
  [[nodiscard]] Parts parts(const RoundTrip& whole, double length, double position) const noexcept;

  /// L of the bore whose ideal lowest resonance is f_b: c/(4 f_b) - 0.613 r_e for the cylinder,
  /// c/(2 f_b) - r_0 - 0.613 r_e for the cone, at least 5 mm.
  [[nodiscard]] double length_for(double bore_frequency) const noexcept;
  /// Inverse of length_for(): the ideal lowest resonance, Hz, of a bore of this length, m.
  [[nodiscard]] double ideal_frequency(double length) const noexcept;
  /// The longest bore that the delay line has room for, m.
  [[nodiscard]] double max_length() const noexcept;

  [[nodiscard]] const Air& air() const noexcept { return air_; }
  /// Z_0 = rho c/S, Pa s/m^3.
  [[nodiscard]] double impedance() const noexcept { return impedance_; }

private:
  [[nodiscard]] double end_correction() const noexcept;
  void set_losses(RoundTrip& trip, double loss) const noexcept;

  Parameters parameters_{};
  const Termination* end_ = nullptr;
  DigitalReflection digital_end_{};
  const Termination* digital_source_ = nullptr; // source from which digital_end_ was computed
  double digital_rate_ = 0, digital_ratio_ = 0;
  Air air_ = air_at(20);
  double rate_ = 48000;
  double impedance_ = 0;
  double spacing_ = 0;                                       // h
  std::array<double, RoundTrip::kLossSections> frequency_{}; // q_k
  std::array<double, RoundTrip::kLossSections> weight_{};    // delta_k/G
  DigitalOpenEnd open_end_{};
};

/// Length of a delay line for the longest bore, internal samples, at this internal rate, Hz.
[[nodiscard]] int max_delay(double internal_rate) noexcept;

} // namespace tactus::reed
