#pragma once

#include "core/geometry/vec3.hpp"
#include "core/object.hpp"

#include <span>
#include <string>
#include <string_view>

namespace tactus::phantom {

constexpr double kMaxCoordinate_mm = 1e4;

/// What a number in a message may be.
struct Range {
  std::string_view name;
  std::string_view unit;
  double lowest, highest;
};

constexpr Range millimetres(std::string_view name) {
  return {name, "mm", -kMaxCoordinate_mm, kMaxCoordinate_mm};
}

[[nodiscard]] inline haptic::Vec3 metres(const double* mm) {
  return haptic::Vec3{mm[0], mm[1], mm[2]} * 1e-3;
}

/// Reads numbers from the words on, one a range; a sentence when one is missing or outside.
[[nodiscard]] std::string read_numbers(std::span<const Atom> words, std::span<const Range> ranges,
                                       double* values);

/// Reads as many numbers as there are words, but no fewer than that; the other values stay. A
/// sentence when there are too many or too few, or one is outside.
[[nodiscard]] std::string read_some(std::span<const Atom> words, std::span<const Range> ranges,
                                    std::size_t min_count, double* values);

/// "hand soft: expected free, rigid, spring or person"
[[nodiscard]] std::string expected(std::string_view message, const Atom& given,
                                   std::string_view choices);

inline bool is(const Atom& atom, std::string_view word) {
  return atom.is_word && atom.word == word;
}

} // namespace tactus::phantom
