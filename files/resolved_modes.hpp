#pragma once

#include "core/modal/table/resolved_modes.hpp"

#include <cstddef>
#include <span>
#include <string>

namespace tactus::files {

/// Reads the payload of an answer of `modal_fem serve` (serve::ModesAnswer) about the table
/// `before`, checked and completed by modal::complete_resolved_modes(). Returns a sentence when
/// something does not fit, and leaves `resolved` as it was; else an empty one. Allocates.
[[nodiscard]] std::string read_resolved_modes(std::span<const std::byte> payload,
                                              const modal::ModalTable& before,
                                              modal::ResolvedModes& resolved);

} // namespace tactus::files
