#pragma once

#include "core/geometry/vec3.hpp"
#include "core/object.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// The words of a message.
using Words = std::span<const Atom>;

constexpr double kMaxCoordinate_mm = 1e4;

/// The range of a number in a message, in its unit.
struct Range {
  std::string_view name;
  std::string_view unit;
  double lowest, highest;
};

constexpr Range millimetres(std::string_view name) {
  return {name, "mm", -kMaxCoordinate_mm, kMaxCoordinate_mm};
}

[[nodiscard]] inline Vec3 metres(const double* mm) { return Vec3{mm[0], mm[1], mm[2]} * 1e-3; }

/// Reads one number for each range from the words. Returns a sentence if a number is missing or
/// outside its range.
[[nodiscard]] std::string read_numbers(Words words, std::span<const Range> ranges, double* values);

/// Reads as many numbers as there are words, at least min_count; the other values stay unchanged.
/// Returns a sentence if there are too many or too few words, or if a number is outside its range.
[[nodiscard]] std::string read_some(Words words, std::span<const Range> ranges,
                                    std::size_t min_count, double* values);

/// The sentence for a wrong word, such as "hand soft: expected free, rigid, spring or person".
[[nodiscard]] std::string expected(std::string_view message, const Atom& given,
                                   std::string_view choices);

/// Joins the words to a list such as "closed, open or swing".
[[nodiscard]] std::string one_of(std::span<const std::string_view> words);

inline bool is(const Atom& atom, std::string_view word) {
  return atom.is_word && atom.word == word;
}

/// The atom's word, or the shortest text of its number.
[[nodiscard]] std::string text_of(const Atom& atom);

/// Splits a line into words; numbers become numeric atoms. Blanks, commas and semicolons separate
/// words; # starts a comment. The words point into the line.
[[nodiscard]] std::vector<Atom> words_of(std::string_view line);

/// Reads the text file that the words name and passes each line to `handle`, without the message's
/// own name (`scene`, `network`) if a line begins with it. Stops at the first refused line and
/// returns a sentence with file and line; returns an empty text if all lines were accepted. A file
/// cannot load another.
[[nodiscard]] std::string handle_file(Words words, std::string_view message, const Host& host,
                                      const std::function<std::string(Words)>& handle);

} // namespace tactus::phantom
