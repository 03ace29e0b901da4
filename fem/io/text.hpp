#pragma once
#include "core/text.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// Cells between separators, blanks and carriage returns around them removed.
[[nodiscard]] std::vector<std::string> split(std::string_view, char separator);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string format(const char* pattern, ...);

} // namespace tactus::fem
