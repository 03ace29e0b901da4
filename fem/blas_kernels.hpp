#pragma once
#include "core/dsp/vector_set.hpp"

#include <string_view>

namespace tactus::fem {

/// The name, for OPENBLAS_CORETYPE, of OpenBLAS kernels that are faster than those in use on a
/// processor with this instruction set; empty if there are none. OpenBLAS chooses by the
/// processor's model: a processor newer than the library gets the kernels of 2004, "Prescott"
/// (OpenBLAS 0.3.21 on an Emerald Rapids).
[[nodiscard]] std::string_view faster_blas_kernels(std::string_view in_use,
                                                   simd::VectorSet widest) noexcept;

/// Restarts this program with faster kernels if there are any, since OpenBLAS selects its kernels
/// before main(). Does nothing if the user has set OPENBLAS_CORETYPE. Call first in main(), with
/// its arguments.
void restart_with_faster_blas_kernels(char** words) noexcept;

} // namespace tactus::fem
