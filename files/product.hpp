#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>

namespace tactus::files {

/// The product of two numbers from a file; nullopt if it exceeds the range of Size (size_t has 32
/// bits in a browser).
template <class Size = std::size_t>
[[nodiscard]] constexpr std::optional<Size> product(std::uint64_t a, std::uint64_t b) noexcept {
  constexpr std::uint64_t kMax = std::numeric_limits<Size>::max();
  if (a > kMax || b > kMax || (a != 0 && b > kMax / a))
    return {};
  return static_cast<Size>(a * b);
}

} // namespace tactus::files
