#pragma once
#include <cstddef>
#include <span>
#include <string>

namespace tactus::fem {

/// SHA-256 (FIPS 180-4), 64 hexadecimal digits.
[[nodiscard]] std::string sha256(std::span<const std::byte>);

} // namespace tactus::fem
