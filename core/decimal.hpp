#pragma once

#include <string_view>
#include <system_error>

namespace tactus {

/// Reads the whole text as std::from_chars reads a double ("3", "-.5", "1e-3"; no plus, no blanks),
/// correctly rounded: the same bits. For C++ libraries whose from_chars reads whole numbers alone
/// (LLVM's before version 20). "inf" and "nan" are invalid_argument here.
[[nodiscard]] std::errc read_decimal(std::string_view text, double& value) noexcept;

} // namespace tactus
