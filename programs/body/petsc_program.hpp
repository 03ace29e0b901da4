#pragma once

#include <algorithm>
#include <cstdio>
#include <petscsys.h>
#include <string>

/// Functions shared by programs that mpi_run starts. They report stages on stdout and a failure as
/// one sentence on stderr. All functions are collective over PETSC_COMM_WORLD.
namespace tactus::petsc {

inline const char* g_program = ""; ///< program's name in sentences
inline std::string g_petsc_error;  ///< PETSc's first error

/// Prints "stage SHARE NAME"; the share 0..1 is the finished part of the stage.
inline void report_progress(double share, const char* stage) {
  PetscPrintf(PETSC_COMM_WORLD, "stage %.3f %s\n", share, stage);
  std::fflush(stdout);
}

/// PETSc's error handler, with its signature: stores the first sentence.
inline PetscErrorCode keep_petsc_error(MPI_Comm, int, const char*, const char*,
                                       PetscErrorCode status, PetscErrorType type, const char* text,
                                       void*) {
  if (type == PETSC_ERROR_INITIAL && text)
    g_petsc_error = text;
  return status;
}

/// Prints the sentence on stderr and returns PETSC_ERR_USER, for which runs() prints no further
/// sentence.
inline PetscErrorCode fail(const std::string& sentence) {
  PetscFPrintf(PETSC_COMM_WORLD, stderr, "%s: %s\n", g_program, sentence.c_str());
  return PETSC_ERR_USER;
}

/// Calls run() between the library's initialisation and finalisation. Returns true if it succeeds;
/// else prints the reason and ends all processes.
inline bool runs(PetscErrorCode (*run)(char** words), char** words, const std::string& library) {
  PetscPushErrorHandler(keep_petsc_error, nullptr);
  const PetscErrorCode status = run(words);
  if (status == 0)
    return true;
  if (status != PETSC_ERR_USER) {
    std::replace(g_petsc_error.begin(), g_petsc_error.end(), '\n', ' ');
    fail(library + " failed: " + (g_petsc_error.empty() ? "no reason given" : g_petsc_error));
  }
  MPI_Abort(PETSC_COMM_WORLD, 1);
  return false;
}

} // namespace tactus::petsc
