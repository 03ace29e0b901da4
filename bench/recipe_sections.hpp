#pragma once

#include <cstddef>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

/// The sections of a recipe's text that sound, and texts in which some of them are silent. It works
/// on the text, through the `level` of a section, so that every random draw stays the same.
namespace tactus::bench {

struct SoundingSection {
  std::string name;             ///< as in the recipe, `solid` as `impact`
  std::size_t number;           ///< among all sections of the text, from 0
  std::size_t same_name_before; ///< how many of that name come before
};

/// Calls `line(text of the line, number of its section)`; lines before the first section: -1.
template <typename Line> void for_each_line(const std::string& text, Line line) {
  std::istringstream lines(text);
  long section = -1;
  for (std::string row; std::getline(lines, row);) {
    if (row.find('[') != row.npos && row.find('[') < row.find('#'))
      ++section;
    line(row, section);
  }
}

inline std::vector<SoundingSection> sounding_sections(const std::string& text) {
  std::vector<SoundingSection> found;
  long last = -1;
  for_each_line(text, [&](const std::string& row, long section) {
    if (section == last)
      return;
    last = section;
    const auto begin = row.find('[') + 1;
    std::string name = row.substr(begin, row.find(']') - begin);
    if (name == "room")
      return;
    if (name == "solid")
      name = "impact";
    std::size_t before = 0;
    for (const SoundingSection& other : found)
      before += other.name == name;
    found.push_back({name, static_cast<std::size_t>(section), before});
  });
  return found;
}

/// The recipe with `level 0` in every sounding section for which `silent(section)` holds.
template <typename ShouldSilence>
std::string silenced(const std::string& text, ShouldSilence silent) {
  const auto sections = sounding_sections(text);
  std::string out;
  long last = -1;
  bool mute = false;
  for_each_line(text, [&](const std::string& row, long number) {
    std::string first;
    std::istringstream(row) >> first;
    if (mute && number == last && first == "level")
      return;
    out += row + "\n";
    if (number == last)
      return;
    last = number;
    mute = false;
    for (const SoundingSection& s : sections)
      mute = mute || (static_cast<long>(s.number) == number && silent(s));
    if (mute)
      out += "level 0\n";
  });
  return out;
}

inline std::string only(const std::string& text, const SoundingSection& kept) {
  return silenced(text, [&](const SoundingSection& s) { return s.number != kept.number; });
}

inline std::string without(const std::string& text, const SoundingSection& excluded) {
  return silenced(text, [&](const SoundingSection& s) { return s.number == excluded.number; });
}

} // namespace tactus::bench
