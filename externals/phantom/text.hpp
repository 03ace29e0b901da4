#pragma once

#include "core/object.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// A word, or a number's shortest text.
[[nodiscard]] std::string text_of(const Atom& atom);

/// The words of a line, numbers as numbers; blanks, commas and semicolons part them, what follows #
/// is a comment. They live as long as the line.
[[nodiscard]] std::vector<Atom> words_of(std::string_view line);

} // namespace tactus::phantom
