#pragma once

#include "core/modal/table/modal_table.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::modal {

/// An answer of `modal_fem serve`: a body in another shape.
struct ResolvedModes {
  ModalTable table;
  std::vector<ModeShare> share; ///< of the modes before
  double seconds = 0, fraction = 1;
};

/// Checks an answer against the table `before`, whose shapes may have been taken out, and adds what
/// the program does not solve again. It must have as many vertices and triangles, the same
/// parameters, and shares whose squares sum to at most 1 for every mode on either side. Returns a
/// sentence when something does not fit, and then leaves `resolved` half complete; else an empty
/// one. Allocates.
///
/// Kept from the table are the triangles; `resid` and `raw_*` as they were; `alpha_rad`, `mp_*` and
/// `mp_band_*` of each mode as the sum over shares of what the modes before had (of `alpha_rad`
/// with the shares' squares), none for a mode that follows none.
[[nodiscard]] std::string complete_resolved_modes(const ModalTable& before,
                                                  ResolvedModes& resolved);

/// Bytes that an answer about such a table may have.
[[nodiscard]] std::uint64_t max_answer_bytes(const ModalTable& before) noexcept;

} // namespace tactus::modal
