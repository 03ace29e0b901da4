#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace tactus::files {

/// A value of a JSON text (RFC 8259), for the descriptions in tables.
struct Json {
  enum class Kind { kNull, kBoolean, kNumber, kText, kList, kObject };
  Kind kind = Kind::kNull;
  double number = 0; ///< a boolean's is 0 or 1
  std::string text;
  std::vector<Json> list;        ///< elements of a list, or an object's values
  std::vector<std::string> keys; ///< names of an object's values

  /// Finds a member of an object by name; if several have the name, the first of them. Null if
  /// there is none or if this value is not an object.
  [[nodiscard]] const Json* find(std::string_view name) const noexcept;
  /// The number with that name, or `fallback` if there is none.
  [[nodiscard]] double number_or(std::string_view name, double fallback) const noexcept;
  [[nodiscard]] std::string text_or(std::string_view name, std::string_view fallback) const;
};

/// Reads a whole text with nlohmann's parser; false if it is not JSON or has more than 32 levels.
/// Strings may be quoted in messages of one line, so their control characters become blanks. Bytes
/// that are not UTF-8 (a file's name on an old system) are kept unchanged.
[[nodiscard]] bool read_json(std::string_view text, Json& value);

/// A text as a JSON string with its quotation marks. Bytes that are not UTF-8 are kept, as
/// read_json() reads them.
[[nodiscard]] std::string quoted_json(std::string_view text);

} // namespace tactus::files
