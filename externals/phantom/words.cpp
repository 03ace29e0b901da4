#include "externals/phantom/words.hpp"

#include "core/declaration_text.hpp"
#include "core/text.hpp"
#include "files/file_bytes.hpp"

#include <algorithm>
#include <fstream>

namespace tactus::phantom {

std::string read_numbers(Words words, std::span<const Range> ranges, double* values) {
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

std::string read_some(Words words, std::span<const Range> ranges, std::size_t min_count,
                      double* values) {
  if (words.size() > ranges.size())
    return "expected at most " + std::to_string(ranges.size()) +
           (ranges.size() == 1 ? " number" : " numbers");
  return read_numbers(words, ranges.first(std::max(words.size(), min_count)), values);
}

std::string expected(std::string_view message, const Atom& given, std::string_view choices) {
  return std::string(message) + " " + text_of(given) + ": expected " + std::string(choices);
}

std::string one_of(std::span<const std::string_view> words) {
  std::string sentence;
  for (std::size_t i = 0; i < words.size(); ++i)
    sentence.append(i == 0 ? "" : i + 1 == words.size() ? " or " : ", ").append(words[i]);
  return sentence;
}

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::vector<Atom> words_of(std::string_view line) {
  std::vector<Atom> words;
  for (const std::string_view word : split_words(line.substr(0, line.find('#')), ",;"))
    if (const auto number = to_number(word))
      words.emplace_back(*number);
    else
      words.emplace_back(word);
  return words;
}

std::string handle_file(Words words, std::string_view message, const Host& host,
                        const std::function<std::string(Words)>& handle) {
  if (words.size() != 1 || !words[0].is_word)
    return "expected a file name";
  const std::string name(words[0].word), found = host.find_file(name);
  std::ifstream stream = files::open_file(found);
  if (found.empty() || !stream)
    return name + ": file not found beside the patch or in the search path";
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::vector<Atom> all = words_of(line);
    Words here(all);
    if (!here.empty() && is(here[0], message))
      here = here.subspan(1);
    if (here.empty())
      continue;
    const std::string refusal =
        is(here[0], "load") ? "load: a " + std::string(message) + " file cannot load another one"
                            : handle(here);
    if (!refusal.empty())
      return name + " line " + std::to_string(number) + ": " + refusal;
  }
  return {};
}

} // namespace tactus::phantom
