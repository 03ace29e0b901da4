// The test programs compute with the kernels that modal_fem computes with.
#include "fem/blas_kernels.hpp"

// glibc gives the words of the command line to what runs before main().
__attribute__((constructor)) static void choose_kernels(int, char** words) {
  tactus::fem::restart_with_faster_blas_kernels(words);
}
