#pragma once

#include "core/modal/table/modal_table.hpp"

#include <cstddef>
#include <span>
#include <string>

namespace tactus::files {

/// Reads a `.modal.npz` that lies in memory; docs/formats/modal_table.md lists the arrays. Returns
/// a sentence when anything in it cannot be right, and then leaves `table` as it was; else an empty
/// one. Allocates; not for the audio path.
[[nodiscard]] std::string read_modal_table(std::span<const std::byte> file,
                                           modal::ModalTable& table);

} // namespace tactus::files
