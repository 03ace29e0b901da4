#pragma once

#include <cstddef>
#include <string_view>

namespace tactus::files {

/// The words of a line, one after the other.
class Words {
public:
  explicit Words(std::string_view line) noexcept : line_(line) {}
  /// The next word, or an empty one.
  std::string_view next() noexcept {
    skip_blanks();
    std::size_t end = 0;
    while (end < line_.size() && !is_blank(line_[end]))
      ++end;
    const std::string_view word = line_.substr(0, end);
    line_.remove_prefix(end);
    return word;
  }
  /// What is left of the line, blanks around it removed.
  std::string_view rest() noexcept {
    skip_blanks();
    while (!line_.empty() && is_blank(line_.back()))
      line_.remove_suffix(1);
    return line_;
  }

private:
  static constexpr bool is_blank(char c) noexcept { return c == ' ' || (c >= '\t' && c <= '\r'); }
  void skip_blanks() noexcept {
    std::size_t begin = 0;
    while (begin < line_.size() && is_blank(line_[begin]))
      ++begin;
    line_.remove_prefix(begin);
  }
  std::string_view line_;
};

/// Calls `use(number, words)` for each line, numbers from one, until it returns false. Lines end
/// with LF, CR LF or CR.
template <class Use> void for_each_line(std::string_view text, Use&& use) {
  constexpr auto kNone = std::string_view::npos;
  std::size_t number = 0, line_feed = text.find('\n');
  for (std::size_t begin = 0; begin < text.size();) {
    if (line_feed < begin)
      line_feed = text.find('\n', begin);
    const std::size_t before = line_feed == kNone ? kNone : line_feed - begin;
    const std::string_view line = text.substr(begin, before);
    const std::size_t size = line.substr(0, line.find('\r')).size();
    if (!use(++number, Words(line.substr(0, size))))
      return;
    begin += size + 1; // a carriage return before a line feed is part of it
    if (begin == line_feed && text[begin - 1] == '\r')
      ++begin;
  }
}

} // namespace tactus::files
