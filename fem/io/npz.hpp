#pragma once
#include "files/npz_writer.hpp"

#include <string>

namespace tactus::fem {

using files::NpzWriter;

/// Writes all arrays; the file appears only when complete. Refuses what is larger than 4 GB.
void write_npz(const std::string& path, const NpzWriter& arrays);
/// The same file in memory.
[[nodiscard]] std::string npz_bytes(const NpzWriter& arrays);

} // namespace tactus::fem
