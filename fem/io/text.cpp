#include "fem/io/text.hpp"

#include <cstdarg>
#include <cstdio>

namespace tactus::fem {

std::vector<std::string> split(std::string_view text, char separator) {
  std::vector<std::string> cells;
  for (std::size_t at = 0;;) {
    const auto end = text.find(separator, at);
    cells.emplace_back(trimmed(text.substr(at, end == std::string_view::npos ? end : end - at)));
    if (end == std::string_view::npos)
      return cells;
    at = end + 1;
  }
}

std::string format(const char* pattern, ...) {
  va_list list, again;
  va_start(list, pattern);
  va_copy(again, list);
  const int size = std::vsnprintf(nullptr, 0, pattern, list);
  va_end(list);
  std::string text(static_cast<std::size_t>(size > 0 ? size : 0), '\0');
  std::vsnprintf(text.data(), text.size() + 1, pattern, again);
  va_end(again);
  return text;
}

} // namespace tactus::fem
