#pragma once
#include "fem/error/balance.hpp"
#include "fem/modes/modes.hpp"

namespace tactus::fem {

/// The estimated discretisation error of each mode's frequency, and each element's share of it.
/// Frequencies of a mesh lie above those of the body.
struct ErrorEstimate {
  std::vector<double> relative; ///< of each frequency
  /// [(mode * elements + element) * 3 + axis]: what each element's reference axis adds to
  /// `relative` of a mode. Elements without axes (tetrahedra) have it all on the first.
  std::vector<float> share;
  std::size_t iterations = 0; ///< conjugate gradient steps, largest number of all blocks
};

struct ErrorSettings {
  double settle = .05; ///< a mode has converged when r'e grows by less in a step
  Progress progress{};
};

/// Hierarchical estimate (Bank & Smith 1993; for eigenvalues Neymeyr 2002, Grubisic & Ovall 2009).
///
/// V is the space of the mesh, W the enriching functions of the next degree. The error of a mode in
/// V + W solves
///
///   (K_WW - K_WV K_VV^-1 K_VW) e = r,   r = lambda M_WV u - K_WV u,   lambda_V - lambda_V+W ~ r'e
///
/// K_VV^-1 is the factor that the modes were computed with, so V and W are fully coupled. Without
/// this coupling the error of thin elements, whose bending is too stiff in V, would be missed. The
/// system is solved by conjugate gradients, preconditioned with the 3 x 3 diagonal blocks of K_WW,
/// for all modes at once; r'e grows from below in each step, and a mode has converged when a step
/// adds less than `settle` of it; the contribution of further steps is extrapolated. The relative
/// error of f is half that of lambda. V + W does not contain a fraction of the error of V: a small
/// one where modes are smooth; where the stress grows as r^(a-1) about (2/3)^(4a), 0.41 at an edge
/// of 270 degrees (a = 0.544). So the contributions of elements at a singular line are divided by
/// 0.5, those of others by 0.78.
[[nodiscard]] ErrorEstimate estimate_errors(const Mesh&, std::span<const Material>, const Matrices&,
                                            ShiftedFactor&, const Modes&,
                                            const ErrorSettings& = {});

/// The contribution of each interval of a swept shape's grid to the error of each mode.
/// `constrained`: of Matrices.
[[nodiscard]] ErrorCells interval_errors(const Mesh&, std::span<const std::uint8_t> constrained,
                                         const ErrorEstimate&, std::size_t intervals);

/// The contribution of each element to the error of each mode.
[[nodiscard]] ErrorCells element_errors(const Mesh&, std::span<const std::uint8_t> constrained,
                                        const ErrorEstimate&);

} // namespace tactus::fem
