#pragma once
#include "fem/io/triangles.hpp"

namespace tactus::fem {

/// STL from the bytes of a file, ASCII or binary. A file is ASCII if it starts with "solid" in any
/// case, names a facet and its length does not fit its binary count; binary files may begin with
/// "solid" too. Each ASCII solid is a group. `path` is for refusals only.
[[nodiscard]] Triangles read_stl(const std::string& path, const std::string& bytes, double unit);

} // namespace tactus::fem
