#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tactus::files {

/// A value of a JSON text (RFC 8259), for the descriptions in tables.
struct Json {
  enum class Kind { kNull, kBoolean, kNumber, kText, kList, kObject };
  Kind kind = Kind::kNull;
  double number = 0; ///< also 0 or 1 of a boolean
  std::string text;
  std::vector<Json> list;        ///< elements of a list, or an object's values
  std::vector<std::string> keys; ///< their names in an object

  /// Member of an object by name, the first of several; null when there is none, or this is no
  /// object.
  [[nodiscard]] const Json* find(std::string_view name) const noexcept;
  /// Number of that name, or the other value.
  [[nodiscard]] double number_or(std::string_view name, double fallback) const noexcept;
  [[nodiscard]] std::string text_or(std::string_view name, std::string_view fallback) const;
};

/// Reads a whole text by nlohmann's parser; false when it is not JSON, or deeper than 32 levels.
/// Texts appear in sentences of one line, so their control characters become blanks. Bytes that are
/// not UTF-8 (a file's name on an old system) are kept unchanged.
[[nodiscard]] bool read_json(std::string_view text, Json& value);

/// A text as a JSON string with its quotation marks. Bytes that are no UTF-8 are kept, as
/// read_json() reads them.
[[nodiscard]] std::string quoted_json(std::string_view text);

} // namespace tactus::files
