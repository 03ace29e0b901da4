#pragma once

#include "core/haptic/device/path.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::files {

/// The rows, or one sentence that names the wrong line.
struct ParsedPath {
  std::vector<haptic::PathRow> rows;
  std::string error;
};

/// Size limit of a path file, large enough for the maximum of two million rows.
inline constexpr std::uint64_t kMaxPathBytes = std::uint64_t{1} << 28;

/// The path of a simulated hand, as rows `ms x y z [buttonmask]` in order of time, positions in mm,
/// separated by blanks, tabs or commas; `#` begins a comment.
[[nodiscard]] ParsedPath parse_path(std::string_view text);

} // namespace tactus::files
