#pragma once
#include "fem/error/balance.hpp"
#include "fem/modes/modes.hpp"

namespace tactus::fem {

/// The estimated discretisation error of each mode's frequency, and each element's share of it. The
/// frequencies of a mesh are higher than those of the body.
struct ErrorEstimate {
  std::vector<double> relative; ///< relative error of each frequency
  /// [(mode * elements + element) * 3 + axis]: the contribution of each element's reference axis to
  /// `relative` of a mode. Elements without axes (tetrahedra) have their whole contribution on the
  /// first axis.
  std::vector<float> share;
  std::size_t iterations = 0; ///< largest number of conjugate gradient steps of a block
};

struct ErrorSettings {
  double settle = .05; ///< a mode has converged if a step adds a smaller share to r'e
  Progress progress{};
};

/// Hierarchical estimate (Bank & Smith 1993; for eigenvalues Neymeyr 2002, Grubisic & Ovall 2009).
///
/// V is the space of the mesh, W the enriching functions of the next degree. The error of a mode in
/// V + W solves
///
///   (K_WW - K_WV K_VV^-1 K_VW) e = r,   r = lambda M_WV u - K_WV u,   lambda_V - lambda_V+W ~ r'e
///
/// The factor that computed the modes gives K_VV^-1, so V and W are fully coupled. Without this
/// coupling the error of thin elements, whose bending is too stiff in V, would be missed. The
/// system is solved by conjugate gradients, preconditioned with the 3 x 3 diagonal blocks of K_WW,
/// for all modes at once. r'e grows in each step, and a mode has converged when a step adds less
/// than `settle` of it. The contribution of further steps is extrapolated. The relative error of f
/// is half that of lambda. V + W misses a fraction of the error of V. This fraction is small where
/// modes are smooth. Where the stress grows as r^(a-1) it is about (2/3)^(4a), 0.41 at an edge of
/// 270 degrees (a = 0.544). So the contributions of elements at a singular line are divided by 0.5,
/// those of other elements by 0.78.
[[nodiscard]] ErrorEstimate estimate_errors(const Mesh&, std::span<const Material>, const Matrices&,
                                            ShiftedFactor&, const Modes&,
                                            const ErrorSettings& = {});

/// The contribution of each interval of a swept shape's grid to the error of each mode.
/// `constrained` is that of Matrices.
[[nodiscard]] ErrorCells interval_errors(const Mesh&, std::span<const std::uint8_t> constrained,
                                         const ErrorEstimate&, std::size_t intervals);

/// The contribution of each element to the error of each mode.
[[nodiscard]] ErrorCells element_errors(const Mesh&, std::span<const std::uint8_t> constrained,
                                        const ErrorEstimate&);

} // namespace tactus::fem
