#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace tactus::files {

/// A whole file below 2 GB; returns why it cannot be read, to follow the file's name, else nothing.
[[nodiscard]] std::string read_file(const std::string& path, std::vector<std::byte>& bytes);

} // namespace tactus::files
