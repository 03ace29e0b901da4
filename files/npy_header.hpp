#pragma once

#include "files/npz.hpp"

namespace tactus::files {

/// Reads the header of an .npy member: type, order and shape go into `array`, the number of bytes
/// before the data into `size`. Returns the error, to be appended to the array's name, or an empty
/// string.
[[nodiscard]] std::string read_npy_header(std::span<const std::byte> bytes, NpzArray& array,
                                          std::size_t& size);

} // namespace tactus::files
