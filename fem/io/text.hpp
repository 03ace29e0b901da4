#pragma once
#include "files/text.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

using files::lower;
using files::to_integer;
using files::to_number;

/// Cells between separators, blanks and carriage returns around them removed.
[[nodiscard]] std::vector<std::string> split(std::string_view, char separator);

/// The text as it may be shown on a terminal: control characters become '?', and text longer than
/// `max_bytes` is cut and ends with "...".
[[nodiscard]] std::string printable(std::string_view, std::size_t max_bytes);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string format(const char* pattern, ...);

} // namespace tactus::fem
