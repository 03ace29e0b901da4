#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace tactus::fem {

/// CRC-32 as in ZIP (polynomial 0xEDB88320).
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte>) noexcept;

/// SHA-256 (FIPS 180-4), 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::span<const std::byte>);

} // namespace tactus::fem
