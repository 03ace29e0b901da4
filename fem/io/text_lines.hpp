#pragma once
#include "fem/io/text.hpp"
#include "fem/mesh/mesh.hpp"

#include <string_view>

namespace tactus::fem {

/// The words of a line, one after the other.
class Tokens {
public:
  explicit Tokens(std::string_view line) : line_(line) {}
  /// The next word, or an empty one.
  std::string_view next() {
    skip_blanks();
    const auto end = std::min(line_.find_first_of(kBlanks), line_.size());
    const std::string_view word = line_.substr(0, end);
    line_.remove_prefix(end);
    return word;
  }
  /// What is left of the line, blanks around it removed.
  std::string_view rest_of_line() {
    skip_blanks();
    return line_.substr(0, line_.find_last_not_of(kBlanks) + 1);
  }

private:
  static constexpr std::string_view kBlanks = " \t\r\n\f\v";
  void skip_blanks() {
    line_.remove_prefix(std::min(line_.find_first_not_of(kBlanks), line_.size()));
  }
  std::string_view line_;
};

/// Calls use(number, words) for every line, numbers from one. Lines end with LF, CR LF or CR.
template <class Use> void for_each_line(std::string_view text, Use&& use) {
  int number = 0;
  while (!text.empty()) {
    const auto end = text.find_first_of("\r\n");
    use(++number, Tokens(text.substr(0, end)));
    if (end == std::string_view::npos)
      return;
    const bool pair = text[end] == '\r' && end + 1 < text.size() && text[end + 1] == '\n';
    text.remove_prefix(end + (pair ? 2 : 1));
  }
}

/// The next three words as coordinates. Refuses others, naming the line.
[[nodiscard]] inline Vector3 read_point(Tokens& tokens, const std::string& path, int line) {
  Vector3 p;
  for (int k = 0; k < 3; ++k) {
    const auto value = to_number(tokens.next());
    if (!value)
      throw InputError(path + " line " + std::to_string(line) + ": expected three coordinates");
    p[k] = *value;
  }
  return p;
}

} // namespace tactus::fem
