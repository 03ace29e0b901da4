#pragma once

#include "core/object.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// A word, or a number's shortest text.
[[nodiscard]] std::string text_of(const Atom& atom);

/// The words of a line, numbers as numbers; blanks, commas and semicolons part them, what follows #
/// is a comment. They live as long as the line.
[[nodiscard]] std::vector<Atom> words_of(std::string_view line);

/// Gives each line of the text file that the words name to `obey`, without the message's own name
/// (`scene`, `network`) where a line begins with it. Ends at the first line that is refused, with a
/// sentence that names file and line; empty when all were obeyed. A file loads no other.
[[nodiscard]] std::string
handle_file(std::span<const Atom> words, std::string_view message, const Host& host,
            const std::function<std::string(std::span<const Atom>)>& handle);

} // namespace tactus::phantom
