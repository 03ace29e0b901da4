#pragma once

#include "core/decimal.hpp"

#include <charconv>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>
#include <version>

/// Words and numbers of text, for every reader of files, settings, options and messages.
namespace tactus {

[[nodiscard]] constexpr bool is_blank(char c) noexcept {
  return c == ' ' || (c >= '\t' && c <= '\r');
}

/// The text without blanks and line ends around it.
[[nodiscard]] constexpr std::string_view trimmed(std::string_view text) noexcept {
  while (!text.empty() && is_blank(text.front()))
    text.remove_prefix(1);
  while (!text.empty() && is_blank(text.back()))
    text.remove_suffix(1);
  return text;
}

#ifdef __cpp_lib_to_chars
inline constexpr bool kFromCharsReadsDoubles = true;
#else
inline constexpr bool kFromCharsReadsDoubles = false; // LLVM's library before version 20
#endif

/// Reads the whole text as a number in the notation of C++ ("3", "-0.5", "1e-3"). A plus sign and
/// blanks may precede the number, and blanks may follow it. Returns invalid_argument if the text is
/// not a finite number, and result_out_of_range if Number cannot hold it; `value` then stays as it
/// is.
template <class Number> std::errc read_number(std::string_view text, Number& value) noexcept {
  text = trimmed(text);
  if (text.starts_with('+') && !text.starts_with("+-"))
    text.remove_prefix(1);
  if constexpr (std::floating_point<Number> && !kFromCharsReadsDoubles) {
    return read_decimal(text, value);
  } else {
    Number found{};
    const char* const end = text.data() + text.size();
    const auto [stopped, error] = std::from_chars(text.data(), end, found);
    if (stopped != end)
      return std::errc::invalid_argument;
    if (error != std::errc{})
      return error;
    if constexpr (std::floating_point<Number>)
      if (!std::isfinite(found))
        return std::errc::invalid_argument;
    value = found;
    return {};
  }
}
/// The number that read_number() reads; nothing if it fails.
template <class Number = double>
[[nodiscard]] std::optional<Number> to_number(std::string_view text) noexcept {
  Number value{};
  return read_number(text, value) == std::errc{} ? std::optional(value) : std::nullopt;
}
/// The number, if it is within a range; else nothing.
template <class Number>
[[nodiscard]] std::optional<Number> to_number(std::string_view text, Number low,
                                              Number high) noexcept {
  const auto value = to_number<Number>(text);
  return value && *value >= low && *value <= high ? value : std::nullopt;
}

/// Letters of ASCII in lower case, all others as they are.
[[nodiscard]] std::string lower(std::string_view);

/// The text as it may be shown on a terminal: control characters become '?', and text longer than
/// `max_bytes` is cut and ends with "...".
[[nodiscard]] std::string printable(std::string_view, std::size_t max_bytes = 256);

/// printf into a string.
[[gnu::format(printf, 1, 2)]] [[nodiscard]] std::string format(const char* pattern, ...);

/// Whether a text equals `name`, which is in lower case, regardless of the text's case.
[[nodiscard]] bool is_word(std::string_view text, std::string_view name) noexcept;

/// The words of a line, one after the other.
class Words {
public:
  /// `separators`: characters that separate words as blanks do.
  explicit Words(std::string_view line, std::string_view separators = {}) noexcept
      : line_(line), separators_(separators) {}
  /// The next word, or an empty one.
  std::string_view next() noexcept {
    skip_blanks();
    std::size_t end = 0;
    while (end < line_.size() && !separates(line_[end]))
      ++end;
    const std::string_view word = line_.substr(0, end);
    line_.remove_prefix(end);
    return word;
  }
  /// The rest of the line, without blanks around it.
  std::string_view rest() noexcept {
    skip_blanks();
    while (!line_.empty() && separates(line_.back()))
      line_.remove_suffix(1);
    return line_;
  }

private:
  [[nodiscard]] bool separates(char c) const noexcept {
    return is_blank(c) || separators_.find(c) != std::string_view::npos;
  }
  void skip_blanks() noexcept {
    while (!line_.empty() && separates(line_.front()))
      line_.remove_prefix(1);
  }
  std::string_view line_, separators_;
};

/// All words of a line.
[[nodiscard]] std::vector<std::string_view> split_words(std::string_view line,
                                                        std::string_view separators = {});

/// Calls `use(number, line)` for each line, numbers from one, until it returns false. Lines end
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
    if (!use(++number, line.substr(0, size)))
      return;
    begin += size + 1; // a carriage return before a line feed is part of it
    if (begin == line_feed && text[begin - 1] == '\r')
      ++begin;
  }
}

} // namespace tactus
