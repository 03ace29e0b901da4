#include "externals/phantom/text.hpp"

#include "core/declaration_text.hpp"
#include "core/text.hpp"
#include "externals/phantom/numbers.hpp"
#include "files/file_bytes.hpp"

#include <fstream>

namespace tactus::phantom {

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

std::string handle_file(std::span<const Atom> words, std::string_view message, const Host& host,
                        const std::function<std::string(std::span<const Atom>)>& handle) {
  if (words.size() != 1 || !words[0].is_word)
    return "expected a file name";
  const std::string name(words[0].word), found = host.find_file(name);
  std::ifstream stream = files::open_file(found);
  if (found.empty() || !stream)
    return name + ": file not found beside the patch or in the search path";
  std::string line;
  for (int number = 1; std::getline(stream, line); ++number) {
    const std::vector<Atom> all = words_of(line);
    std::span<const Atom> here(all);
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
