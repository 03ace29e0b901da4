#pragma once

#include "core/haptic/device/path.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::files {

/// Either rows or one sentence with the number of the line that is wrong.
struct ParsedPath {
  std::vector<haptic::PathRow> rows;
  std::string error;
};

/// The path of a simulated hand, as rows `ms x y z [buttonmask]` in order of time, positions in mm,
/// separated by blanks, tabs or commas; `#` begins a comment.
[[nodiscard]] ParsedPath parse_path(std::string_view text);

} // namespace tactus::files
