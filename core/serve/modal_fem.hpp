#pragma once

#include "core/serve/protocol.hpp"

#include <cstdint>

/// Messages of `modal_fem serve FILE.modal.npz`, which computes the modes of a table's body at
/// other shapes. docs/formats/serve.md lists them. A request `solve` is f64 parameters [P], m, then
/// f64 [P], m, the parameters of the reference shape: the new modes are matched with those of this
/// shape. A solve depends on nothing but its request: the program may restart between two solves.
namespace tactus::serve {

struct ModesReady {
  std::uint64_t modes = 0, vertices = 0, parameters = 0; ///< sizes of the table: K, V, P
};

/// The fixed part of an answer. `shares` modal::ModeShares follow
/// (core/modal/table/resolved_modes.hpp), then to the end a modal table (NPZ) of the new shape,
/// whose array `displacement` [P] holds the parameters that were reached.
struct ModesAnswer {
  double seconds = 0;  ///< duration of the solve
  double fraction = 1; ///< share of the move that keeps the mesh valid
  std::uint64_t shares = 0;
};

} // namespace tactus::serve
