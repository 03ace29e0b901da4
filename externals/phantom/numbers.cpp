#include "externals/phantom/numbers.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>

namespace tactus::phantom {

std::string read_numbers(std::span<const Atom> words, std::span<const Range> ranges,
                         double* values) {
  for (std::size_t i = 0; i < ranges.size(); ++i) {
    const Range& range = ranges[i];
    const std::string unit = range.unit.empty() ? "" : " " + std::string(range.unit);
    const std::string range_text =
        "expected " + number_text(range.lowest) + ".." + number_text(range.highest) + unit;
    if (i >= words.size())
      return std::string(range.name) + " needs a value: " + range_text;
    if (words[i].is_word)
      return std::string(range.name) + " " + std::string(words[i].word) + ": " + range_text;
    if (!(words[i].number >= range.lowest && words[i].number <= range.highest))
      return std::string(range.name) + " " + number_text(words[i].number) + unit + ": " +
             range_text;
    values[i] = words[i].number;
  }
  return {};
}

std::string read_some(std::span<const Atom> words, std::span<const Range> ranges,
                      std::size_t min_count, double* values) {
  if (words.size() > ranges.size())
    return "expected at most " + std::to_string(ranges.size()) +
           (ranges.size() == 1 ? " number" : " numbers");
  return read_numbers(words, ranges.first(std::max(words.size(), min_count)), values);
}

std::string expected(std::string_view message, const Atom& given, std::string_view choices) {
  return std::string(message) + " " +
         (given.is_word ? std::string(given.word) : number_text(given.number)) + ": expected " +
         std::string(choices);
}

} // namespace tactus::phantom
