#pragma once

#include "core/modal/table/modal_table.hpp"

#include <cstdint>
#include <string>
#include <vector>

namespace tactus::modal {

/// An answer of `modal_fem serve`: a body in another shape.
struct ResolvedModes {
  ModalTable table;
  std::vector<ModeShare> share; ///< shares of the earlier modes
  double seconds = 0, fraction = 1;
};

/// Checks an answer against the table `before`, whose shapes may have been removed, and adds the
/// arrays that the program does not solve again. The answer must have as many vertices and
/// triangles as `before`, the same parameters, and shares whose squares sum to at most 1 for every
/// mode on either side. If something does not fit, returns a sentence and leaves `resolved`
/// incomplete; else returns an empty string. Allocates.
///
/// Copied from `before` are the triangles, `resid` and `raw_*`. `alpha_rad`, `mp_*` and `mp_band_*`
/// of a mode are the sums over its shares of the earlier modes' values (for `alpha_rad` with the
/// squares of the shares), and zero for a mode without a predecessor.
[[nodiscard]] std::string complete_resolved_modes(const ModalTable& before,
                                                  ResolvedModes& resolved);

/// Bytes that an answer about this table may have.
[[nodiscard]] std::uint64_t max_answer_bytes(const ModalTable& before) noexcept;

} // namespace tactus::modal
