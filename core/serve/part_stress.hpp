#pragma once

#include "core/serve/protocol.hpp"

#include <cstdint>

/// Messages of `part_stress serve FILE.stress.npz`, which solves the part of a table at other
/// shapes. docs/formats/serve.md lists them. A request `solve` is u32 ServeMethod, u32 ServeFlags,
/// f64 parameters [P] in m.
namespace tactus::serve {

enum class ServeMethod : std::uint32_t { chosen = 0, pcg = 1, refactor = 2 };

/// Bits of a request.
enum ServeFlags : std::uint32_t {
  kWithDerivatives = 1, ///< solves by a new factor, whatever the method
  kKeepFactor = 2,      ///< PCG that takes many iterations is not followed by a factorisation
};

struct ServeReady {
  std::uint64_t elements = 0, parameters = 0;      ///< N, P
  double product_s = 0, solve_s = 0, factor_s = 0; ///< measured
};

/// The fixed part of an answer. After it come f64 parameters [P] (those reached), f32 von Mises
/// [N], f32 max shear [N] and, if requested, f32 S [P,N], f32 S_shear [P,N].
struct StressAnswer {
  std::uint32_t method = 0, iterations = 0;
  double seconds = 0;
  double fraction = 1; ///< share of the move that keeps the mesh valid
  double residual = 0;
};

} // namespace tactus::serve
