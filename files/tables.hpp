#pragma once

#include "core/modal/table/resolved_modes.hpp"
#include "core/stress/stress_table.hpp"

#include <cstddef>
#include <span>
#include <string>

/// Readers of tables that are in memory. docs/formats/modal_table.md and
/// docs/formats/stress_table.md describe the arrays. Each reader returns an empty text, or a
/// sentence that names the wrong array, its shape or value, and what was expected; the target is
/// then unchanged. Readers allocate, so they are not for the audio path.
namespace tactus::files {

/// Reads a `.modal.npz` file.
[[nodiscard]] std::string read_modal_table(std::span<const std::byte> file,
                                           modal::ModalTable& table);
/// Reads the payload of an answer of `modal_fem serve` (serve::ModesAnswer) about the table
/// `before`, checked and completed by modal::complete_resolved_modes().
[[nodiscard]] std::string read_resolved_modes(std::span<const std::byte> payload,
                                              const modal::ModalTable& before,
                                              modal::ResolvedModes& resolved);
/// Reads a `.stress.npz` file.
[[nodiscard]] std::string read_stress_table(std::span<const std::byte> file,
                                            stress::StressTable& table);

} // namespace tactus::files
