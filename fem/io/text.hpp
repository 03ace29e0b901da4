#pragma once
#include "core/text.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::fem {

/// The cells between separators, without surrounding blanks and carriage returns.
[[nodiscard]] std::vector<std::string> split(std::string_view, char separator);

using tactus::format;

} // namespace tactus::fem
