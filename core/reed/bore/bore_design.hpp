#pragma once

#include "core/reed/bore/air.hpp"
#include "core/reed/bore/open_end.hpp"
#include "core/reed/bore/termination.hpp"
#include "core/reed/instrument/parameters.hpp"

#include <array>
#include <complex>

namespace tactus::reed {

/// Digital filters of one round trip through the bore: the wall loss, sections side by side,
///   H_l = 1 + sum_k r_k z^-1/(1 - p_k z^-1),
/// times a gain, which gives what reaches the end; then the open end. Each state is as small as its
/// effect, so that single-precision lanes keep their accuracy.
struct RoundTrip {
  static constexpr int kLossSections = 8; // a power of two
  double delay = 3;                       // D, internal samples, fractional
  std::array<double, kLossSections> loss_pole{}, loss_residue{};
  double incident_gain = 1;
  DigitalOpenEnd end{};

  /// The filters a share of the way from one bore to one near it; the delay is that of `to`.
  static RoundTrip interpolate(const RoundTrip& from, const RoundTrip& to, double share) noexcept;
};

/// From the shape of the bore to its filters, at one internal sample rate.
///
/// The wall loss exp(-G sqrt(s)) follows from sqrt(s) = 1/pi int_0^inf s/(s + q) q^(-1/2) dq: eight
/// values q_k spaced by a factor e^h from 2 pi 3 to 2 pi min(0.4 fs, 20000) rad/s, each giving a
/// pole at q_k e^(-delta/2) and a zero at q_k e^(delta/2), delta_k = G h/pi sqrt(q_k) times a share
/// that fits attenuation and phase at once (bore_design.cpp); in discrete time at exp(pole T) and
/// exp(zero T). Every section has |H| <= 1, so has the row of them; its partial fractions are what
/// is computed. The open end is OpenEnd's (open_end.hpp); holes and bells (set_end()) are filters
/// of their own behind these (termination.hpp), and the open end is then idle. The delay makes the
/// phase of the whole round trip exact at the ideal lowest resonance; modes 1 to 6 of tubes from
/// 0.3 to 5 m then lie within 1 cent.
class BoreDesign {
public:
  /// Lowest bore frequency a line has room for, Hz.
  static constexpr double kLowestFrequency = 8;
  static constexpr double kHighestFrequency = 4000;

  /// Air, bore and end, without digital filters: for all below but round_trip() and parts().
  void set_geometry(const Parameters& parameters) noexcept;
  /// The same with filters for that many samples a second.
  void set(const Parameters& parameters, double internal_rate) noexcept;
  /// What the bore ends in, which must live on; null: an open end.
  void set_end(const Termination* end) noexcept;
  [[nodiscard]] const Termination* end() const noexcept { return end_; }
  /// Reflectance of the end, extra length included.
  [[nodiscard]] std::complex<double> end_reflection(std::complex<double> s) const noexcept;

  [[nodiscard]] RoundTrip round_trip(double length) const noexcept;
  /// The same round trip in two parts, that to a place (m) on the line and back and that beyond it:
  /// the losses and the delay of each, `whole` being that of both.
  struct Parts {
    RoundTrip above{}, below{};
  };
  [[nodiscard]] Parts parts(const RoundTrip& whole, double length, double position) const noexcept;

  /// L of the bore whose ideal lowest resonance is f_b: c/(4 f_b) - 0.613 r_e for the cylinder,
  /// c/(2 f_b) - r_0 - 0.613 r_e for the cone, at least 5 mm.
  [[nodiscard]] double length_for(double bore_frequency) const noexcept;
  /// The inverse: where the ideal lowest resonance lies.
  [[nodiscard]] double ideal_frequency(double length) const noexcept;
  /// The longest bore that the line has room for.
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
  const Termination* digital_source_ = nullptr; // what it is the filter of
  double digital_rate_ = 0, digital_ratio_ = 0;
  Air air_ = air_at(20);
  double rate_ = 48000;
  double impedance_ = 0;
  double spacing_ = 0;                                       // h
  std::array<double, RoundTrip::kLossSections> frequency_{}; // q_k
  std::array<double, RoundTrip::kLossSections> weight_{};    // delta_k/G
  DigitalOpenEnd open_end_{};
};

/// Internal samples of delay line that hold the longest bore at that internal rate.
[[nodiscard]] int max_delay(double internal_rate) noexcept;

} // namespace tactus::reed
