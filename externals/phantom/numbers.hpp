#pragma once

#include "core/geometry/vec3.hpp"
#include "core/object.hpp"

#include <span>
#include <string>
#include <string_view>

namespace tactus::phantom {

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
[[nodiscard]] std::string read_numbers(std::span<const Atom> words, std::span<const Range> ranges,
                                       double* values);

/// Reads as many numbers as there are words, at least min_count; the other values stay. Returns a
/// sentence when there are too many or too few, or one is outside its range.
[[nodiscard]] std::string read_some(std::span<const Atom> words, std::span<const Range> ranges,
                                    std::size_t min_count, double* values);

/// The sentence for a wrong word: "hand soft: expected free, rigid, spring or person".
[[nodiscard]] std::string expected(std::string_view message, const Atom& given,
                                   std::string_view choices);

inline bool is(const Atom& atom, std::string_view word) {
  return atom.is_word && atom.word == word;
}

} // namespace tactus::phantom
