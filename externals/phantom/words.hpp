#pragma once

#include "core/geometry/vec3.hpp"
#include "core/object.hpp"

#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace tactus::phantom {

/// Those of a message.
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

/// Reads one number for each range from the words. Returns a sentence when one is missing or
/// outside its range.
[[nodiscard]] std::string read_numbers(Words words, std::span<const Range> ranges, double* values);

/// Reads as many numbers as there are words, at least min_count; the other values stay. Returns a
/// sentence when there are too many or too few, or one is outside its range.
[[nodiscard]] std::string read_some(Words words, std::span<const Range> ranges,
                                    std::size_t min_count, double* values);

/// The sentence for a wrong word: "hand soft: expected free, rigid, spring or person".
[[nodiscard]] std::string expected(std::string_view message, const Atom& given,
                                   std::string_view choices);

/// "closed, open or swing"
[[nodiscard]] std::string one_of(std::span<const std::string_view> words);

inline bool is(const Atom& atom, std::string_view word) {
  return atom.is_word && atom.word == word;
}

/// A word, or a number's shortest text.
[[nodiscard]] std::string text_of(const Atom& atom);

/// Splits a line into words; numbers become numeric atoms. Blanks, commas and semicolons separate
/// words; # starts a comment. The words point into the line.
[[nodiscard]] std::vector<Atom> words_of(std::string_view line);

/// Reads the text file that the words name and passes each line to `handle`, without the message's
/// own name (`scene`, `network`) where a line begins with it. Stops at the first refused line and
/// returns a sentence with file and line; empty when all lines were accepted. A file cannot load
/// another.
[[nodiscard]] std::string handle_file(Words words, std::string_view message, const Host& host,
                                      const std::function<std::string(Words)>& handle);

} // namespace tactus::phantom
