// The lowest modes of K u = lambda M u on several processes, for modal_fem --engine slepc.
//
//   mpirun -n RANKS slepc_solve MATRICES RIGID VALUES VECTORS COUNT RIGID_COUNT SHIFT [SLEPc's
//   options]
//
// MATRICES contains K and M, RIGID the RIGID_COUNT rigid motions, which are deflated, both in
// PETSc's binary format. The results are written to VALUES (one vector) and VECTORS, ascending.
// SHIFT is s in rad^2/s^2: Krylov-Schur on (K + s M)^-1 M with MUMPS' distributed factor. A single
// start vector finds the second copy of a multiple eigenvalue only through rounding, so the number
// of eigenvalues is checked: K - sigma M, with sigma in a gap above the last requested mode, has as
// many negative pivots as there are eigenvalues below sigma (Sylvester). Missing eigenvalues are
// searched for orthogonally to those found.
//
// While it works it prints "stage SHARE NAME" on stdout, and at the end "peak BYTES" of the largest
// process.
#include "programs/body/petsc_program.hpp"

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <slepceps.h>
#include <string>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <vector>

namespace {

using tactus::petsc::fail;
using tactus::petsc::report_progress;

struct Counted {
  double found_before = 0, requested = 1;
};

// SLEPc's monitor, with its signature.
PetscErrorCode monitor(EPS, PetscInt, PetscInt found, PetscScalar*, PetscScalar*, PetscReal*,
                       PetscInt, void* context) {
  const auto* counted = static_cast<const Counted*>(context);
  const double share = (counted->found_before + static_cast<double>(found)) / counted->requested;
  report_progress(std::min(.99, share), "finding modes");
  return 0;
}

/// K - sigma M, to be factorised by MUMPS.
PetscErrorCode prepare_factor(KSP solver) {
  PC preconditioner = nullptr;
  PetscCall(KSPSetType(solver, KSPPREONLY));
  PetscCall(KSPGetPC(solver, &preconditioner));
  PetscCall(PCSetType(preconditioner, PCCHOLESKY));
  PetscCall(PCFactorSetMatSolverType(preconditioner, MATSOLVERMUMPS));
  return 0;
}

/// Counts the eigenvalues of (K, M) below sigma.
PetscErrorCode count_below(Mat stiffness, Mat mass, PetscReal sigma, PetscInt& below) {
  Mat shifted = nullptr, factor = nullptr;
  PetscCall(MatDuplicate(stiffness, MAT_COPY_VALUES, &shifted));
  PetscCall(MatAXPY(shifted, -sigma, mass, SUBSET_NONZERO_PATTERN));
  PetscCall(MatSetOption(shifted, MAT_SYMMETRIC, PETSC_TRUE));
  KSP solver = nullptr;
  PC preconditioner = nullptr;
  PetscCall(KSPCreate(PETSC_COMM_WORLD, &solver));
  PetscCall(KSPSetOperators(solver, shifted, shifted));
  PetscCall(prepare_factor(solver));
  PetscCall(KSPGetPC(solver, &preconditioner));
  PetscCall(PCFactorSetUpMatSolverType(preconditioner));
  PetscCall(PCFactorGetMatrix(preconditioner, &factor));
  PetscCall(MatMumpsSetIcntl(factor, 24, 1)); // detects null pivots
  PetscCall(MatMumpsSetIcntl(factor, 13, 1)); // without ScaLAPACK for the root, MUMPS counts the
                                              // pivots
  PetscCall(KSPSetUp(solver));
  PetscInt zero = 0, above = 0;
  PetscCall(MatGetInertia(factor, &below, &zero, &above));
  PetscCall(KSPDestroy(&solver));
  PetscCall(MatDestroy(&shifted));
  return 0;
}

struct Pair {
  PetscReal value;
  Vec vector;
};

/// Whether an M-normalised vector lies outside the span of the first `known` pairs: rounding lets
/// deflated pairs reappear.
PetscErrorCode is_fresh(Mat mass, const std::vector<Pair>& pairs, std::size_t known, Vec vector,
                        bool& is_new) {
  Vec weighted = nullptr;
  PetscCall(VecDuplicate(vector, &weighted));
  PetscCall(MatMult(mass, vector, weighted));
  PetscReal length = 0, within = 0;
  PetscCall(VecDot(vector, weighted, &length));
  for (std::size_t k = 0; k < known; ++k) {
    PetscReal along = 0;
    PetscCall(VecDot(pairs[k].vector, weighted, &along));
    within += along * along;
  }
  PetscCall(VecDestroy(&weighted));
  is_new = within < .5 * length;
  return 0;
}

/// The problem K x = lambda M x of a body with these rigid motions. The search starts at -shift.
struct Problem {
  Mat stiffness = nullptr, mass = nullptr;
  PetscReal shift = 0;
  std::vector<Vec> rigid{};
};

/// Adds at least `requested` converged pairs that are M-orthogonal to `pairs` and to the rigid
/// motions. Frees the factor on return, so that this factor and that of the count are never in
/// memory together.
PetscErrorCode find_pairs(const Problem& problem, std::vector<Pair>& pairs, PetscInt requested,
                          Counted& counted) {
  report_progress(0, "factorising");
  EPS solver = nullptr;
  ST transform = nullptr;
  KSP linear = nullptr;
  PetscCall(EPSCreate(PETSC_COMM_WORLD, &solver));
  PetscCall(EPSSetOperators(solver, problem.stiffness, problem.mass));
  PetscCall(EPSSetProblemType(solver, EPS_GHEP));
  PetscCall(EPSSetWhichEigenpairs(solver, EPS_TARGET_MAGNITUDE));
  PetscCall(EPSSetTarget(solver, -problem.shift));
  PetscCall(EPSSetTolerances(solver, 1e-10, 500));
  PetscCall(EPSMonitorSet(solver, monitor, &counted, nullptr));
  PetscCall(EPSGetST(solver, &transform));
  PetscCall(STSetType(transform, STSINVERT));
  PetscCall(STGetKSP(transform, &linear));
  PetscCall(prepare_factor(linear));
  PetscCall(EPSSetFromOptions(solver));

  std::vector<Vec> deflated = problem.rigid;
  for (const Pair& pair : pairs)
    deflated.push_back(pair.vector);
  if (!deflated.empty())
    PetscCall(
        EPSSetDeflationSpace(solver, static_cast<PetscInt>(deflated.size()), deflated.data()));
  counted.found_before = static_cast<double>(pairs.size());
  PetscCall(EPSSetDimensions(solver, requested, PETSC_DEFAULT, PETSC_DEFAULT));
  PetscCall(EPSSolve(solver));
  PetscInt found = 0;
  PetscCall(EPSGetConverged(solver, &found));
  const std::size_t known = pairs.size();
  for (PetscInt k = 0; k < found; ++k) {
    Pair pair{};
    PetscCall(MatCreateVecs(problem.mass, &pair.vector, nullptr));
    PetscCall(EPSGetEigenpair(solver, k, &pair.value, nullptr, pair.vector, nullptr));
    bool is_new = false;
    PetscCall(is_fresh(problem.mass, pairs, known, pair.vector, is_new));
    if (is_new)
      pairs.push_back(pair);
    else
      PetscCall(VecDestroy(&pair.vector));
  }
  PetscCall(EPSDestroy(&solver));
  std::stable_sort(pairs.begin(), pairs.end(),
                   [](const Pair& a, const Pair& b) { return a.value < b.value; });
  return 0;
}

/// The sigma for counting: in the largest gap between two pairs from number `count` on, or above
/// the last pair if these pairs all form one group. `last` is the pair below sigma.
PetscReal gap_above(const std::vector<Pair>& pairs, std::size_t count, std::size_t& last) {
  constexpr PetscReal kGroup = 1 + 1e-4;
  PetscReal widest = kGroup;
  last = pairs.size() - 1;
  for (std::size_t k = count - 1; k + 1 < pairs.size(); ++k)
    if (const PetscReal gap = pairs[k + 1].value / pairs[k].value; gap > widest) {
      widest = gap;
      last = k;
    }
  return pairs[last].value * (1 + (widest - 1) / 2);
}

PetscErrorCode write(const std::vector<Pair>& pairs, const char* values, const char* vectors) {
  PetscViewer target = nullptr;
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, vectors, FILE_MODE_WRITE, &target));
  PetscCall(PetscViewerBinarySetSkipInfo(target, PETSC_TRUE));
  for (const Pair& pair : pairs)
    PetscCall(VecView(pair.vector, target));
  PetscCall(PetscViewerDestroy(&target));
  Vec list = nullptr;
  PetscCall(
      VecCreateMPI(PETSC_COMM_WORLD, PETSC_DECIDE, static_cast<PetscInt>(pairs.size()), &list));
  PetscInt first = 0, end = 0;
  PetscCall(VecGetOwnershipRange(list, &first, &end));
  for (PetscInt k = first; k < end; ++k)
    PetscCall(VecSetValue(list, k, pairs[static_cast<std::size_t>(k)].value, INSERT_VALUES));
  PetscCall(VecAssemblyBegin(list));
  PetscCall(VecAssemblyEnd(list));
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, values, FILE_MODE_WRITE, &target));
  PetscCall(PetscViewerBinarySetSkipInfo(target, PETSC_TRUE));
  PetscCall(VecView(list, target));
  PetscCall(PetscViewerDestroy(&target));
  PetscCall(VecDestroy(&list));
  return 0;
}

/// Reads the matrices and the rigid motions from the files that the command line names.
PetscErrorCode read_matrices(char** words, Problem& problem) {
  PetscViewer source = nullptr;
  PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, words[1], FILE_MODE_READ, &source));
  for (Mat* matrix : {&problem.stiffness, &problem.mass}) {
    PetscCall(MatCreate(PETSC_COMM_WORLD, matrix));
    PetscCall(MatSetType(*matrix, MATAIJ));
    PetscCall(MatLoad(*matrix, source));
    PetscCall(MatSetOption(*matrix, MAT_SYMMETRIC, PETSC_TRUE));
  }
  PetscCall(PetscViewerDestroy(&source));
  if (!problem.rigid.empty()) {
    PetscCall(PetscViewerBinaryOpen(PETSC_COMM_WORLD, words[2], FILE_MODE_READ, &source));
    for (Vec& motion : problem.rigid) {
      PetscCall(MatCreateVecs(problem.stiffness, &motion, nullptr));
      PetscCall(VecLoad(motion, source));
    }
    PetscCall(PetscViewerDestroy(&source));
  }
  return 0;
}

PetscErrorCode run(char** words) {
  PetscInt count = 0, rigid_count = 0;
  PetscReal shift = 0;
  PetscCall(PetscOptionsStringToInt(words[5], &count));
  PetscCall(PetscOptionsStringToInt(words[6], &rigid_count));
  PetscCall(PetscOptionsStringToReal(words[7], &shift));

  report_progress(0, "reading the matrices");
  Problem problem{.shift = shift};
  problem.rigid.resize(static_cast<std::size_t>(rigid_count));
  PetscCall(read_matrices(words, problem));

  Counted counted{.requested = static_cast<double>(count)};
  std::vector<Pair> pairs;
  PetscInt missing = count;
  for (int attempt = 0; attempt < 4 && missing > 0; ++attempt) {
    const std::size_t before = pairs.size();
    PetscCall(find_pairs(problem, pairs, missing, counted));
    const bool enough = pairs.size() >= static_cast<std::size_t>(count);
    if (pairs.size() == before && !enough)
      break;
    if (!enough) {
      missing = count - static_cast<PetscInt>(pairs.size());
      continue;
    }
    report_progress(0, "counting the modes again");
    std::size_t last = 0;
    const PetscReal sigma = gap_above(pairs, static_cast<std::size_t>(count), last);
    PetscInt below = 0;
    PetscCall(count_below(problem.stiffness, problem.mass, sigma, below));
    missing = below - rigid_count - static_cast<PetscInt>(last + 1);
  }
  if (missing != 0)
    return fail("SLEPc's modes are not the lowest " + std::to_string(count) + ": " +
                std::to_string(missing) + " are missing according to the matrix's inertia");

  report_progress(0, "writing the modes");
  PetscCall(write(pairs, words[3], words[4]));
  for (Pair& pair : pairs)
    PetscCall(VecDestroy(&pair.vector));
  for (Vec& motion : problem.rigid)
    PetscCall(VecDestroy(&motion));
  PetscCall(MatDestroy(&problem.stiffness));
  PetscCall(MatDestroy(&problem.mass));
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  double own = 1024. * static_cast<double>(usage.ru_maxrss), max_bytes = 0;
  MPI_Reduce(&own, &max_bytes, 1, MPI_DOUBLE, MPI_MAX, 0, PETSC_COMM_WORLD);
  PetscCall(PetscPrintf(PETSC_COMM_WORLD, "peak %.0f\n", max_bytes));
  return 0;
}

} // namespace

int main(int argc, char** argv) {
  tactus::petsc::g_program = "slepc_solve";
  ::prctl(PR_SET_PDEATHSIG, SIGKILL); // ends with mpirun
  if (argc < 8) {
    std::fputs("slepc_solve: run by modal_fem --engine slepc\n", stderr);
    return 2;
  }
  if (SlepcInitialize(&argc, &argv, nullptr, nullptr) != 0)
    return 1;
  if (!tactus::petsc::runs(run, argv, "SLEPc"))
    return 1;
  return SlepcFinalize() != 0;
}
