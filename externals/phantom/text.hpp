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

/// Splits a line into words; numbers become numeric atoms. Blanks, commas and semicolons separate
/// words; # starts a comment. The words point into the line.
[[nodiscard]] std::vector<Atom> words_of(std::string_view line);

/// Reads the text file that the words name and passes each line to `handle`, without the message's
/// own name (`scene`, `network`) where a line begins with it. Stops at the first refused line and
/// returns a sentence with file and line; empty when all lines were accepted. A file cannot load
/// another.
[[nodiscard]] std::string
handle_file(std::span<const Atom> words, std::string_view message, const Host& host,
            const std::function<std::string(std::span<const Atom>)>& handle);

} // namespace tactus::phantom
