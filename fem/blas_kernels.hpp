#pragma once
#include "core/dsp/vector_set.hpp"

#include <string_view>

namespace tactus::fem {

/// The name of faster OpenBLAS kernels than those in use, for OPENBLAS_CORETYPE, on a processor
/// that runs this set; empty when there are none. OpenBLAS chooses by the processor's model: one
/// that is newer than the library gets the kernels of 2004, "Prescott" (OpenBLAS 0.3.21 on an
/// Emerald Rapids).
[[nodiscard]] std::string_view faster_blas_kernels(std::string_view in_use,
                                                   simd::VectorSet widest) noexcept;

/// Restarts this program with faster kernels if there are any, since OpenBLAS selects its kernels
/// before main(). Does nothing if the user has set OPENBLAS_CORETYPE. Call first in main(), with
/// its arguments.
void restart_with_faster_blas_kernels(char** words) noexcept;

} // namespace tactus::fem
