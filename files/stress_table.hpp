#pragma once

#include "core/stress/stress_table.hpp"

#include <cstddef>
#include <span>
#include <string>

namespace tactus::files {

/// Reads a `.stress.npz` that lies in memory; docs/formats/stress_table.md lists the arrays.
/// Returns a sentence that names the array, its shape or value and what was expected, and then
/// leaves `table` as it was; else an empty one. Allocates.
[[nodiscard]] std::string read_stress_table(std::span<const std::byte> file,
                                            stress::StressTable& table);

} // namespace tactus::files
