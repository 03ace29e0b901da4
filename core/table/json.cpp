#include "core/table/json.hpp"

#include <charconv>
#include <cmath>

namespace tactus::table {
namespace {

class Reader {
public:
  explicit Reader(std::string_view text) : rest_(text) {}

  bool whole(Json& value) {
    if (!any(value, 0))
      return false;
    space();
    return rest_.empty();
  }

private:
  static constexpr int kDeepest = 32;

  void space() {
    const std::size_t next = rest_.find_first_not_of(" \t\r\n");
    rest_.remove_prefix(next == std::string_view::npos ? rest_.size() : next);
  }
  bool take(char letter) {
    space();
    if (rest_.empty() || rest_[0] != letter)
      return false;
    rest_.remove_prefix(1);
    return true;
  }
  bool word(std::string_view expected) {
    if (!rest_.starts_with(expected))
      return false;
    rest_.remove_prefix(expected.size());
    return true;
  }

  bool any(Json& value, int depth) {
    space();
    if (rest_.empty() || depth > kDeepest)
      return false;
    switch (rest_[0]) {
    case '{':
      return object(value, depth);
    case '[':
      return list(value, depth);
    case '"':
      value.kind = Json::Kind::kText;
      return text(value.text);
    case 't':
      value.kind = Json::Kind::kBoolean;
      value.number = 1;
      return word("true");
    case 'f':
      value.kind = Json::Kind::kBoolean;
      return word("false");
    case 'n':
      return word("null");
    default:
      return number(value);
    }
  }

  [[nodiscard]] bool is_digit(std::size_t at) const noexcept {
    return at < rest_.size() && rest_[at] >= '0' && rest_[at] <= '9';
  }

  bool number(Json& value) {
    value.kind = Json::Kind::kNumber;
    const std::size_t first = rest_[0] == '-' ? 1 : 0;
    if (!is_digit(first) || (rest_[first] == '0' && is_digit(first + 1)))
      return false;
    const auto read = std::from_chars(rest_.data(), rest_.data() + rest_.size(), value.number);
    if (read.ec != std::errc{} || !std::isfinite(value.number))
      return false;
    const auto used = static_cast<std::size_t>(read.ptr - rest_.data());
    const std::size_t point = rest_.substr(0, used).find('.');
    if (point != std::string_view::npos && !is_digit(point + 1))
      return false;
    rest_.remove_prefix(used);
    return true;
  }

  /// Escapes of letters beyond ASCII become a question mark: names are only shown.
  bool text(std::string& out) {
    if (!take('"'))
      return false;
    while (!rest_.empty() && rest_[0] != '"') {
      char letter = rest_[0];
      rest_.remove_prefix(1);
      if (static_cast<unsigned char>(letter) < 0x20)
        return false;
      if (letter == '\\') {
        if (rest_.empty())
          return false;
        letter = rest_[0];
        rest_.remove_prefix(1);
        if (letter == 'u') {
          if (rest_.find_first_not_of("0123456789abcdefABCDEF") < 4 || rest_.size() < 4)
            return false;
          rest_.remove_prefix(4);
          letter = '?';
        } else if (letter == 'n' || letter == 't' || letter == 'r' || letter == 'b' ||
                   letter == 'f') {
          letter = ' ';
        } else if (letter != '"' && letter != '\\' && letter != '/') {
          return false;
        }
      }
      out += letter;
    }
    return take('"');
  }

  bool list(Json& value, int depth) {
    value.kind = Json::Kind::kList;
    take('[');
    if (take(']'))
      return true;
    do {
      if (!any(value.list.emplace_back(), depth + 1))
        return false;
    } while (take(','));
    return take(']');
  }

  bool object(Json& value, int depth) {
    value.kind = Json::Kind::kObject;
    take('{');
    if (take('}'))
      return true;
    do {
      space();
      if (!text(value.keys.emplace_back()) || !take(':') ||
          !any(value.list.emplace_back(), depth + 1))
        return false;
    } while (take(','));
    return take('}');
  }

  std::string_view rest_;
};

} // namespace

const Json* Json::find(std::string_view name) const noexcept {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] == name)
      return &list[i];
  return nullptr;
}

double Json::number_or(std::string_view name, double fallback) const noexcept {
  const Json* value = find(name);
  return value && value->kind == Kind::kNumber ? value->number : fallback;
}

std::string Json::text_or(std::string_view name, std::string_view fallback) const {
  const Json* value = find(name);
  return value && value->kind == Kind::kText ? value->text : std::string(fallback);
}

bool read_json(std::string_view text, Json& value) {
  value = {};
  return Reader(text).whole(value);
}

} // namespace tactus::table
