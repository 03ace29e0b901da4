// K u = f on several processes, for part_stress --engine petsc.
//
//   mpirun -n RANKS petsc_solve MATRIX VECTORS SOLUTION TOLERANCE [PETSc's options]
//
// MATRIX holds K; VECTORS holds f, an initial u and the coordinates of the nodes, three numbers per
// node in the order of the unknowns. All are in PETSc's binary form. The program writes u to
// SOLUTION. It uses conjugate gradients with smoothed aggregation (GAMG), whose near null space is
// that of a rigid body (Adams, Evaluation of three unstructured multigrid methods on 3D finite
// element problems in solid mechanics, 2002), until ||f - K u|| <= TOLERANCE ||f||.
//
// While it works it prints "stage SHARE NAME" on stdout; at the end it prints "iterations N" and
// for each process "process RANK BYTES CPU_SECONDS".
#include "programs/body/petsc_program.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <petscksp.h>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <vector>

namespace {

using tactus::petsc::fail;
using tactus::petsc::report_progress;

struct Goal {
  double tolerance = 0, size = 0, first = 0;
};

PetscErrorCode monitor(KSP, PetscInt iteration, PetscReal residual, void* context) {
  auto* goal = static_cast<Goal*>(context);
  if (iteration == 0)
    goal->first = std::max(residual, goal->size);
  const double whole = std::log(goal->tolerance * goal->size / goal->first);
  if (whole < 0 && residual > 0)
    report_progress(std::clamp(std::log(residual / goal->first) / whole, 0., .99),
                    "conjugate gradients");
  return 0;
}

/// Reads K, f, the initial u and the nodes from the files that the command line names.
PetscErrorCode read_equations(char** words, Mat& stiffness, Vec& load, Vec& solution, Vec& nodes) {
  PetscViewer source = nullptr;
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, words[1], FILE_MODE_READ, &source));
  PetscCall(MatCreate(PETSC_COMM_WORLD, &stiffness));
  PetscCall(MatSetType(stiffness, MATAIJ));
  PetscCall(MatSetBlockSize(stiffness, 3)); // a node's three rows stay in one process
  PetscCall(MatLoad(stiffness, source));
  PetscCall(PetscViewerDestroy(&source));
  PetscCall(MatSetOption(stiffness, MAT_SPD, PETSC_TRUE));
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, words[2], FILE_MODE_READ, &source));
  for (Vec* vector : {&load, &solution, &nodes}) {
    PetscCall(MatCreateVecs(stiffness, vector, nullptr));
    PetscCall(VecLoad(*vector, source));
  }
  PetscCall(PetscViewerDestroy(&source));
  return 0;
}

/// Prints each process's largest memory, bytes, and processor time, s.
PetscErrorCode print_processes() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  const auto seconds = [](const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
  };
  const double own[2]{1024. * static_cast<double>(usage.ru_maxrss),
                      seconds(usage.ru_utime) + seconds(usage.ru_stime)};
  int ranks = 0;
  MPI_Comm_size(PETSC_COMM_WORLD, &ranks);
  std::vector<double> all(2 * static_cast<std::size_t>(ranks));
  MPI_Gather(own, 2, MPI_DOUBLE, all.data(), 2, MPI_DOUBLE, 0, PETSC_COMM_WORLD);
  for (int k = 0; k < ranks; ++k)
    PetscCall(PetscPrintf(PETSC_COMM_WORLD, "process %d %.0f %.3f\n", k,
                          all[2 * static_cast<std::size_t>(k)],
                          all[2 * static_cast<std::size_t>(k) + 1]));
  return 0;
}

PetscErrorCode run(char** words) {
  Goal goal;
  PetscCall(PetscOptionsStringToReal(words[4], &goal.tolerance));

  report_progress(0, "reading the equations");
  Mat stiffness = nullptr;
  Vec load = nullptr, solution = nullptr, nodes = nullptr;
  PetscCall(read_equations(words, stiffness, load, solution, nodes));

  report_progress(0, "building the levels");
  MatNullSpace rigid = nullptr;
  PetscCall(MatNullSpaceCreateRigidBody(nodes, &rigid));
  PetscCall(MatSetNearNullSpace(stiffness, rigid));
  PetscCall(MatNullSpaceDestroy(&rigid));
  KSP solver = nullptr;
  PC preconditioner = nullptr;
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
  PetscCall(KSPSetOperators(solver, stiffness, stiffness));
  PetscCall(KSPSetType(solver, KSPCG));
  PetscCall(KSPSetNormType(solver, KSP_NORM_UNPRECONDITIONED));
  PetscCall(KSPSetInitialGuessNonzero(solver, PETSC_TRUE));
  // The residual of the recurrence drifts from the true one, so a tenth of the tolerance is used.
  constexpr PetscInt kMaxIterations = 2000;
  PetscCall(KSPSetTolerances(solver, .1 * goal.tolerance, PETSC_DEFAULT, 1e30, kMaxIterations));
  PetscCall(KSPGetPC(solver, &preconditioner));
  PetscCall(PCSetType(preconditioner, PCGAMG));
  PetscCall(KSPSetFromOptions(solver));
  PetscCall(VecNorm(load, NORM_2, &goal.size));
  PetscCall(KSPMonitorSet(solver, monitor, &goal, nullptr));
  PetscCall(KSPSetUp(solver));
  PetscCall(KSPSolve(solver, load, solution));
  KSPConvergedReason reason = KSP_CONVERGED_ITERATING;
  PetscInt iterations = 0;
  PetscReal residual = 0;
  PetscCall(KSPGetConvergedReason(solver, &reason));
  PetscCall(KSPGetIterationNumber(solver, &iterations));
  PetscCall(KSPGetResidualNorm(solver, &residual));
  if (reason < 0) {
    char text[200];
    std::snprintf(text, sizeof text,
                  "conjugate gradients ended at a residual of %.1e of the load after %d iterations "
                  "(%s), expected %.0e",
                  goal.size > 0 ? residual / goal.size : residual, static_cast<int>(iterations),
                  KSPConvergedReasons[reason], goal.tolerance);
    return fail(text);
  }

  report_progress(1, "writing the displacement");
  PetscViewer target = nullptr;
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, words[3], FILE_MODE_WRITE, &target));
  PetscCall(PetscViewerBinarySetSkipInfo(target, PETSC_TRUE));
  PetscCall(VecView(solution, target));
  PetscCall(PetscViewerDestroy(&target));
  PetscCall(KSPDestroy(&solver));
  for (Vec* vector : {&load, &solution, &nodes})
    PetscCall(VecDestroy(vector));
  PetscCall(MatDestroy(&stiffness));
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "iterations %d\n", static_cast<int>(iterations)));
  return print_processes();
}

} // namespace

int main(int argc, char** argv) {
  tactus::petsc::g_program = "petsc_solve";
  ::prctl(PR_SET_PDEATHSIG, SIGKILL); // ends with mpirun
  if (argc < 5) {
    std::fputs("petsc_solve: run by part_stress --engine petsc\n", stderr);
    return 2;
  }
  if (PetscInitialize(&argc, &argv, nullptr, nullptr) != 0)
    return 1;
  if (!tactus::petsc::runs(run, argv, "PETSc"))
    return 1;
  return PetscFinalize() != 0;
}
