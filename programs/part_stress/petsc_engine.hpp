#pragma once
#include "fem/statics/statics.hpp"
#include "programs/body/progress.hpp"

namespace tactus::fem {

/// ||f - K u|| / ||f|| at which the processes stop.
constexpr double kPetscTolerance = 1e-8;

/// Refuses if mpirun or this build's PETSc program is missing, and names the Debian packages.
void check_petsc();

/// Computes the same solution as solve_static(), by PETSc on `ranks` processes of mpirun. It uses
/// conjugate gradients with smoothed aggregation (GAMG), whose coarse spaces contain the six rigid
/// motions. K, f and the nodes are passed through a private folder (MpiRun). `start` is an initial
/// displacement, or empty. Prints memory and time of each process. Refuses too many processes
/// (check_ranks()); reports a failure in one sentence.
[[nodiscard]] StaticSolution petsc_solution(const Mesh&, const StaticSystem&,
                                            std::span<const double> start, int ranks,
                                            ProgressLine&);

} // namespace tactus::fem
