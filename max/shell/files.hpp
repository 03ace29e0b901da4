#pragma once

#include "max/abi/max_abi.h"

#include <string>
#include <string_view>
#include <vector>

/// Files and buffers by name, as Max users expect them to be found.
namespace tactus::max {

/// Full path, UTF-8 with slashes, of an existing file: as it is, beside the patcher, or in Max's
/// search path, there also by its name without folders. Empty if there is none.
[[nodiscard]] std::string find_file(t_object* box, std::string_view name);
/// Full path for a file to be written; relative names are beside the patcher, or in Max's default
/// folder while it has not been saved.
[[nodiscard]] std::string new_file(t_object* box, std::string_view name);
/// The first channel of a buffer~; false if there is none of this name.
[[nodiscard]] bool read_buffer(t_object* box, std::string_view name, std::vector<double>& values);

} // namespace tactus::max
