#pragma once

#include "core/reed/bore/termination.hpp"

#include <complex>
#include <span>

namespace tactus::reed {

/// One point of a response to be approximated.
struct ResponsePoint {
  double omega;                  // rad/s
  std::complex<double> response; // H(i omega)
  double weight;
};
inline constexpr std::size_t kMaxResponsePoints = 192;

/// Blocks of poles (Termination) such that dc_value + sum of r s/(s - p) comes close to the
/// response: vector fitting (Gustavsen & Semlyen 1999, relaxed as in 2006), poles in the left half
/// plane, as many as the blocks hold, from resonances up to `top` rad/s. Bounded work, no
/// allocation. False, and the blocks as they were, where the response is no number.
[[nodiscard]] bool fit_poles(std::span<const ResponsePoint> points, double dc_value,
                             double max_omega, std::span<Termination::Block> blocks) noexcept;

/// Largest |H| on the frequency axis.
[[nodiscard]] double largest_response(double dc_value,
                                      std::span<const Termination::Block> blocks) noexcept;

/// dc_value + sum of r s/(s - p).
[[nodiscard]] std::complex<double> response_of(double dc_value,
                                               std::span<const Termination::Block> blocks,
                                               std::complex<double> s) noexcept;

} // namespace tactus::reed
