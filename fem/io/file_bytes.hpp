#pragma once
#include <cstdint>
#include <string>

namespace tactus::fem {

/// All bytes of a regular file. Refuses what is no regular file (a pipe or a device may never end)
/// and what is larger than `largest` bytes.
[[nodiscard]] std::string read_bytes(const std::string& path,
                                     std::uint64_t largest = std::uint64_t{4} << 30);

} // namespace tactus::fem
