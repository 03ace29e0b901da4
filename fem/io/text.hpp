#pragma once
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// The whole text as a finite number, else nothing. Blanks around it are allowed.
[[nodiscard]] std::optional<double> to_number(std::string_view);
[[nodiscard]] std::optional<int> to_integer(std::string_view);

/// Cells between separators, blanks and carriage returns around them removed.
[[nodiscard]] std::vector<std::string> split(std::string_view, char separator);

[[nodiscard]] std::string lower(std::string_view);

/// The text as it may be shown on a terminal: control characters become '?', and what is longer
/// than `longest` bytes ends with "...".
[[nodiscard]] std::string printable(std::string_view, std::size_t max_bytes);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string format(const char* pattern, ...);

} // namespace tactus::fem
