#pragma once
#include "fem/modes/shifted_factor.hpp"

namespace tactus::fem {

/// What a run of conjugate gradients reports.
struct CgReport {
  int iterations = 0;
  double residual = 0;  ///< ||b - K x|| / ||b||
  double condition = 1; ///< of the preconditioned matrix, from the Lanczos matrix of the run
  bool converged = false;
};

/// Solves K x = b from the start x by conjugate gradients, preconditioned with the factor of
/// another matrix of the same size (Golub & Van Loan, Matrix Computations, 11.5). Held directions
/// stay zero. Ends at ||b - K x|| <= tolerance ||b||, after `max_iterations`, or where rounding
/// allows no further progress.
[[nodiscard]] CgReport conjugate_gradients(const Matrices&, ShiftedFactor& preconditioner,
                                           std::span<const double> b, std::span<double> x,
                                           double tolerance, int max_iterations);

/// Combined approximations (Kirsch 1991): the best solution, in the energy norm, in the space of
/// r1 = K0^-1 b, r_k+1 = r_k - K0^-1 K r_k, k < `vectors`. The same Krylov space as conjugate
/// gradients from zero; one product and one solve a vector. Returns ||b - K x|| / ||b||.
double combined_approximations(const Matrices&, ShiftedFactor& old_factor,
                               std::span<const double> b, std::span<double> x,
                               std::size_t vectors = 3);

} // namespace tactus::fem
