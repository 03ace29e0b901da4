#pragma once
#include <cstdint>
#include <string>

namespace tactus::fem {

/// Reads a whole regular file. Refuses anything else (a pipe or a device may never end) and a file
/// of more than `largest` bytes.
[[nodiscard]] std::string read_bytes(const std::string& path,
                                     std::uint64_t largest = std::uint64_t{4} << 30);

} // namespace tactus::fem
