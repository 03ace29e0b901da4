#pragma once

#include "core/text.hpp"

namespace tactus::programs {

/// The I-th of N equal shares of a computation, for batches: --part I/N.
struct Part {
  std::size_t part = 1, parts = 1;
};
/// Returns nullopt unless 1 <= I <= N.
[[nodiscard]] inline std::optional<Part> to_part(std::string_view text) noexcept {
  const std::size_t slash = text.find('/');
  if (slash == std::string_view::npos)
    return std::nullopt;
  const auto part = to_number<std::size_t>(text.substr(0, slash)),
             parts = to_number<std::size_t>(text.substr(slash + 1));
  return part && parts && *part >= 1 && *part <= *parts ? std::optional(Part{*part, *parts})
                                                        : std::nullopt;
}

} // namespace tactus::programs
