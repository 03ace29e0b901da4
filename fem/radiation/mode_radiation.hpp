#pragma once
#include "fem/modes/modes.hpp"

#include <complex>

namespace tactus::fem {

/// How modes sound into all directions; the arrays mp_* and alpha_rad of a table.
struct ModeRadiation {
  std::vector<std::int32_t> highest_degree;      ///< [K]
  std::vector<std::int64_t> offset;              ///< [K+1], into one ratio's coefficients
  std::vector<double> ratios;                    ///< of frequency, ascending; {1} alone is usual
  std::vector<std::complex<float>> coefficients; ///< [ratios][offset[K]], Pa s/(m sqrt(kg))
  Vector3 centre;
  double reference_radius = 0;        ///< m, of the smallest sphere about the centre
  std::vector<double> decay_rate;     ///< [K] 1/s: radiated power over twice the energy
  std::vector<double> efficiency;     ///< [K] power over rho c ∫ v_n^2/2 dS
  std::size_t triangles = 0;
  double resolved_hz = 0;             ///< up to here a wave has four edges of the acoustic mesh
  [[nodiscard]] bool empty() const noexcept { return coefficients.empty(); }
};

struct RadiationSettings {
  std::size_t triangles = 2000;
  std::vector<double> ratios{1};
  double air_density = 1.184, sound_speed = 346.1;
  double memory_limit_bytes = 0; ///< 0: none
  Report report{};
  /// One sentence: mesh, memory and time ahead, after the first solution was timed.
  std::function<void(const std::string&)> say{};
};

/// Solves the air around the free body for each mode, all modes of nearly equal frequency (0.1 %)
/// at once at their mean. Refuses when the matrix would not fit into memory.
[[nodiscard]] ModeRadiation radiate(const Mesh&, const Modes&, const RadiationSettings&);

} // namespace tactus::fem
