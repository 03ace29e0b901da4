#pragma once
#include "core/text.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// Cells between separators, blanks and carriage returns around them removed.
[[nodiscard]] std::vector<std::string> split(std::string_view, char separator);

using tactus::format;

} // namespace tactus::fem
