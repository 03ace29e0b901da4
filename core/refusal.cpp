#include "core/refusal.hpp"

#include "core/declaration_text.hpp"

#include <algorithm>
#include <array>

namespace tactus {
namespace {

constexpr std::size_t kMaxShown = 8;    // values
constexpr std::size_t kMaxLength = 120; // characters of a word

/// Allocates nothing: the result of number_text() fits into a std::string's own buffer.
void append(Sentence& sentence, const Atom& value) {
  if (!value.is_word)
    sentence += number_text(value.number);
  else
    sentence += value.word.substr(0, kMaxLength);
  if (value.is_word && value.word.size() > kMaxLength)
    sentence += "...";
}

void append_range(Sentence& sentence, double lowest, double highest) {
  sentence += number_text(lowest);
  sentence += "..";
  sentence += number_text(highest);
}

} // namespace

Sentence refusal(std::string_view message, std::span<const Atom> given, std::string_view expected) {
  Sentence sentence(message);
  std::size_t shown = 0, length = 0;
  for (; shown < std::min(given.size(), kMaxShown) && length < kMaxLength; ++shown) {
    sentence += " ";
    append(sentence, given[shown]);
    length += given[shown].is_word ? given[shown].word.size() : 0;
  }
  if (shown < given.size())
    sentence += " ...";
  sentence += ": expected ";
  sentence += expected;
  return sentence;
}

Sentence modes_refusal(std::span<const Atom> given, const ModeRanges& ranges) {
  struct Range {
    std::string_view name, unit;
    double lowest, highest;
  };
  const std::array<Range, 3> columns{
      {{"frequency", " Hz", ranges.min_frequency_hz, ranges.max_frequency_hz},
       {"time", " s", ranges.min_t60_s, ranges.max_t60_s},
       {"gain", "", ranges.min_gain, ranges.max_gain}}};
  Sentence sentence("modes: ");
  for (std::size_t i = 0; i < given.size(); ++i) {
    const Range& range = columns[i % columns.size()];
    if (!given[i].is_word && given[i].number >= range.lowest && given[i].number <= range.highest)
      continue;
    sentence += range.name;
    sentence += " ";
    append(sentence, given[i]);
    sentence += range.unit;
    sentence += " of mode ";
    const std::size_t mode = i / columns.size() + 1;
    sentence += number_text(static_cast<double>(mode));
    sentence += ": expected ";
    append_range(sentence, range.lowest, range.highest);
    return sentence;
  }
  if (given.size() % 3 == 0)
    return Sentence("");
  sentence += number_text(static_cast<double>(given.size()));
  sentence += given.size() == 1 ? " number" : " numbers";
  sentence += ": expected three for each mode, a frequency in ";
  for (std::size_t column = 0; column < columns.size(); ++column) {
    const Range& range = columns[column];
    sentence += column == 0 ? "" : column == 1 ? ", a time in " : " and a gain in ";
    append_range(sentence, range.lowest, range.highest);
    sentence += range.unit;
  }
  return sentence;
}

} // namespace tactus
