#pragma once

#include <optional>
#include <string>
#include <string_view>

/// Words and numbers of text files.
namespace tactus::files {

/// The text without blanks and line ends around it.
[[nodiscard]] std::string_view trimmed(std::string_view) noexcept;

/// The whole text as a finite number, else nothing. Blanks around it and a plus are allowed.
[[nodiscard]] std::optional<double> to_number(std::string_view) noexcept;
[[nodiscard]] std::optional<int> to_integer(std::string_view) noexcept;

/// Letters of ASCII in lower case, all others as they are.
[[nodiscard]] std::string lower(std::string_view);

/// Whether a text is `name`, which is in lower case, but for the case of its letters.
[[nodiscard]] bool is_word(std::string_view text, std::string_view name) noexcept;

} // namespace tactus::files
