#include "externals/phantom/text.hpp"

#include "core/words.hpp"

#include <charconv>

namespace tactus::phantom {

std::string text_of(const Atom& atom) {
  return atom.is_word ? std::string(atom.word) : number_text(atom.number);
}

std::vector<Atom> words_of(std::string_view line) {
  std::vector<Atom> words;
  constexpr std::string_view kBlanks = " \t\r,;";
  line = line.substr(0, line.find('#'));
  while (true) {
    const std::size_t begin = line.find_first_not_of(kBlanks);
    if (begin == std::string_view::npos)
      return words;
    line.remove_prefix(begin);
    const std::string_view word = line.substr(0, line.find_first_of(kBlanks));
    double number = 0;
    const auto read = std::from_chars(word.data(), word.data() + word.size(), number);
    if (read.ec == std::errc() && read.ptr == word.data() + word.size())
      words.emplace_back(number);
    else
      words.emplace_back(word);
    line.remove_prefix(word.size());
  }
}

} // namespace tactus::phantom
