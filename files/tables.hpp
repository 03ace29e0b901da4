#pragma once

#include "core/modal/table/resolved_modes.hpp"
#include "core/stress/stress_table.hpp"

#include <cstddef>
#include <span>
#include <string>

/// Readers of tables that lie in memory, for their arrays see docs/formats/modal_table.md and
/// docs/formats/stress_table.md. Each returns a sentence when anything cannot be right (the array,
/// its shape or value, and what was expected), and then leaves its target as it was; else an empty
/// one. They allocate; not for the audio path.
namespace tactus::files {

/// A `.modal.npz`.
[[nodiscard]] std::string read_modal_table(std::span<const std::byte> file,
                                           modal::ModalTable& table);
/// The payload of an answer of `modal_fem serve` (serve::ModesAnswer) about the table `before`,
/// checked and completed by modal::complete_resolved_modes().
[[nodiscard]] std::string read_resolved_modes(std::span<const std::byte> payload,
                                              const modal::ModalTable& before,
                                              modal::ResolvedModes& resolved);
/// A `.stress.npz`.
[[nodiscard]] std::string read_stress_table(std::span<const std::byte> file,
                                            stress::StressTable& table);

} // namespace tactus::files
