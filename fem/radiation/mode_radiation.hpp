#pragma once
#include "fem/modes/modes.hpp"

#include <complex>

namespace tactus::fem {

/// The sound field that each mode radiates, as coefficients of outgoing spherical waves: the arrays
/// mp_* and alpha_rad of a table.
struct ModeRadiation {
  std::vector<std::int32_t> max_degree;          ///< [K]
  std::vector<std::int64_t> offset;              ///< [K+1], into one ratio's coefficients
  std::vector<double> ratios;                    ///< ratios of frequency, ascending; usually only
                                                 ///< {1}
  std::vector<std::complex<float>> coefficients; ///< [ratios][offset[K]], Pa s/(m sqrt(kg))
  Vec3 centre;
  double reference_radius = 0;    ///< radius of the smallest sphere about the centre, m
  std::vector<double> decay_rate; ///< [K] 1/s: radiated power over twice the energy
  std::vector<double> efficiency; ///< [K] power over rho c ∫ v_n^2/2 dS
  std::size_t triangles = 0;
  double resolved_hz = 0; ///< up to here a wavelength has at least four edges of the acoustic mesh
  /// The waves of every mode's motion at frequencies common to all modes, for forced vibration; the
  /// arrays mp_band_*. Empty unless requested.
  struct Band {
    std::vector<double> frequency_hz;              ///< [F], ascending
    std::vector<std::int32_t> max_degree;          ///< [K]
    std::vector<std::int64_t> offset;              ///< [K+1], into one frequency's coefficients
    std::vector<std::complex<float>> coefficients; ///< [F][offset[K]], Pa s/(m sqrt(kg))
  } band;
  [[nodiscard]] bool empty() const noexcept { return coefficients.empty(); }
};

struct RadiationSettings {
  std::size_t triangles = 2000;
  std::vector<double> ratios{1};
  double air_density = 1.184, sound_speed = 346.1;
  double memory_limit_bytes = 0; ///< 0 for no limit
  double band_limit_hz = 0;      ///< if above 0, the band up to there is computed too
  Report report{};
  /// Called with one sentence on mesh, memory and remaining time, once the first solution has been
  /// timed.
  std::function<void(const std::string&)> notify{};
};

/// Frequencies at which the waves of a body of radius a = `radius` are computed. Between them
/// coefficients can be interpolated, after the travel time from half the radius is divided out.
/// They start at k a = 0.2, in steps of about 0.5, or wider if there would be more than 60.
/// Resonances of cavities that are narrower than a step are missed.
[[nodiscard]] std::vector<double> band_frequencies(double radius, double limit_hz,
                                                   double sound_speed);

/// Computes the air around the free body for each mode. Modes of nearly equal frequency (0.1 %) are
/// solved together at their mean frequency. Refuses a matrix that would not fit into memory.
[[nodiscard]] ModeRadiation radiate(const Mesh&, const Modes&, const RadiationSettings&);

} // namespace tactus::fem
