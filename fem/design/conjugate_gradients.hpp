#pragma once
#include "fem/modes/shifted_factor.hpp"

namespace tactus::fem {

/// The report of a run of conjugate gradients.
struct CgReport {
  int iterations = 0;
  double residual = 0;  ///< ||b - K x|| / ||b||
  double condition = 1; ///< condition of the preconditioned matrix, from the run's Lanczos matrix
  bool converged = false;
};

/// Solves K x = b from the start x by conjugate gradients, preconditioned with the factor of
/// another matrix of the same size in single precision (Golub & Van Loan, Matrix Computations,
/// 11.5). Constrained directions stay zero. Ends at ||b - K x|| <= tolerance ||b||, after
/// `max_iterations`, or when rounding prevents further progress.
[[nodiscard]] CgReport conjugate_gradients(const Matrices&, ShiftedFactor& preconditioner,
                                           std::span<const double> b, std::span<double> x,
                                           double tolerance, int max_iterations);

/// Combined approximations (Kirsch 1991): the best solution, in the energy norm, in the space of r1
/// = K0^-1 b, r_k+1 = r_k - K0^-1 K r_k, k < `vectors`. This is the Krylov space of conjugate
/// gradients from zero. Each vector costs one product and one solve. Returns ||b - K x|| / ||b||.
double combined_approximations(const Matrices&, ShiftedFactor& old_factor,
                               std::span<const double> b, std::span<double> x,
                               std::size_t vectors = 3);

} // namespace tactus::fem
