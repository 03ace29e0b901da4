#pragma once

#include "core/dsp/complex.hpp"
#include "core/reed/bore/termination.hpp"

#include <span>

namespace tactus::reed {

/// One point of a frequency response to be approximated.
struct ResponsePoint {
  double omega;     // rad/s
  Complex response; // H(i omega)
  double weight;
};
inline constexpr std::size_t kMaxResponsePoints = 192;

/// Approximates a response by poles p and residues r, H(s) = dc_value + sum of r s/(s - p), by
/// vector fitting (Gustavsen & Semlyen 1999, relaxed: Gustavsen 2006).
///
/// The poles lie in the left half plane, two per block; the first guesses are resonances up to
/// max_omega, rad/s. Bounded work, no allocation. Returns false, with the blocks unchanged, if a
/// response is not a number, if there are too few or too many points, or if the equations are
/// singular.
[[nodiscard]] bool fit_poles(std::span<const ResponsePoint> points, double dc_value,
                             double max_omega, std::span<Termination::Block> blocks) noexcept;

/// Largest |H(i omega)|, by scanning 0.1 to 1e7 rad/s and refining each peak.
[[nodiscard]] double largest_response(double dc_value,
                                      std::span<const Termination::Block> blocks) noexcept;

/// H(s) = dc_value + sum of r s/(s - p).
[[nodiscard]] Complex response_of(double dc_value, std::span<const Termination::Block> blocks,
                                  Complex s) noexcept;

} // namespace tactus::reed
