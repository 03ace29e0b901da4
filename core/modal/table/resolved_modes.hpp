#pragma once

#include "core/modal/table/modal_table.hpp"
#include "core/modal/table/serve_protocol.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace tactus::modal {

/// An answer of `modal_fem serve`: a body in another shape.
struct ResolvedModes {
  ModalTable table;
  std::vector<ModeShare> share; ///< of the modes before
  double seconds = 0, fraction = 1;
};

/// Reads the payload of an answer (ModesAnswer). What it says must fit the table `before` (whose
/// shapes may have been taken out): as many vertices and triangles, the same parameters; shares
/// whose squares sum to at most 1 for every mode on either side. Returns a sentence when something
/// does not, and leaves `resolved` as it was; else an empty one. Allocates.
///
/// What the program does not solve anew is kept: the triangles; `resid` and `raw_*` as they were;
/// `alpha_rad`, `mp_*` and `mp_band_*` of each mode as the sum over shares of what the modes before
/// had (of `alpha_rad` with the shares' squares), none for a mode that follows none.
[[nodiscard]] std::string read_resolved_modes(std::span<const std::byte> payload,
                                              const ModalTable& before, ResolvedModes& resolved);

/// Bytes that an answer about such a table may have.
[[nodiscard]] std::uint64_t max_answer_bytes(const ModalTable& before) noexcept;

} // namespace tactus::modal
