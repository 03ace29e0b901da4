#include "fem/io/text.hpp"

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

} // namespace tactus::fem
