#pragma once

#include "core/table/serve_protocol.hpp"

#include <cstdint>

/// Messages of `modal_fem serve FILE.modal.npz`, which finds the modes of a table's body at other
/// shapes. docs/modal_fem.md lists them. A request `solve` is f64 parameters [P], then f64 [P] the
/// parameters of the shape whose modes are to be matched with the new ones, m. Solves are functions
/// of the request alone: the program may be started anew between two of them.
namespace tactus::modal {

using table::ServeHeader;
using table::ServeKind;

struct ModesReady {
  std::uint64_t modes = 0, vertices = 0, parameters = 0; ///< of the table: K, V, P
};

/// How far a mode of the earlier shape goes on as a mode of the new one: their modal coordinates
/// are z_now = sum over before of share z_before. The shares are a partial isometry, so that no
/// energy arises: +-1 for a mode that keeps its shape, a rotation among modes of like frequency
/// that mix, nothing for a mode that has no successor.
struct ModeShare {
  std::uint32_t before = 0, now = 0; ///< numbers of the modes
  double share = 0;                  ///< -1..1
};

/// The fixed part of an answer. `shares` ModeShares follow, then to the end a modal table (NPZ) of
/// the new shape, its array `displacement` [P] the parameters that were reached.
struct ModesAnswer {
  double seconds = 0;  ///< that the solve took
  double fraction = 1; ///< of the move that keeps the mesh valid
  std::uint64_t shares = 0;
};

} // namespace tactus::modal
