#include "files/json.hpp"

#include <nlohmann/json.hpp>

#include <cstdint>
#include <utility>

namespace tactus::files {
namespace {

using Parser = nlohmann::json;

constexpr std::size_t kMaxDepth = 32; ///< maximum number of lists and objects that enclose a value

// nlohmann's parser refuses text that is not UTF-8. A byte b above 127 passes through it as the
// private code point U+10F000 + b, in UTF-8: F4 8F 80+(b >> 6) 80+(b & 63).
constexpr std::string_view kByteMark = "\xF4\x8F";

std::string bytes_as_code_points(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x80) {
      out += c;
      continue;
    }
    out += kByteMark;
    out += static_cast<char>(0x80 | byte >> 6);
    out += static_cast<char>(0x80 | (byte & 0x3f));
  }
  return out;
}

std::string code_points_as_bytes(std::string_view text) {
  std::string out;
  out.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto at = [&](std::size_t k) { return static_cast<unsigned char>(text[i + k]); };
    if (text.substr(i).starts_with(kByteMark) && at(2) <= 0x83) {
      out += static_cast<char>((at(2) & 3) << 6 | (at(3) & 0x3f));
      i += 3;
    } else {
      out += text[i];
    }
  }
  return out;
}

std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20)
      c = ' ';
  return text;
}

/// Receives the parser's events. The parser does not recurse and asks before every value whether to
/// continue, so a text of a million brackets ends at kMaxDepth.
class Builder final : public nlohmann::json_sax<Parser> {
public:
  explicit Builder(Json& root) : root_(root) {}

  bool null() override { return add(Json::Kind::kNull) != nullptr; }
  bool boolean(bool value) override { return number(Json::Kind::kBoolean, value ? 1 : 0); }
  bool number_integer(std::int64_t value) override {
    return number(Json::Kind::kNumber, static_cast<double>(value));
  }
  bool number_unsigned(std::uint64_t value) override {
    return number(Json::Kind::kNumber, static_cast<double>(value));
  }
  bool number_float(double value, const std::string&) override {
    return number(Json::Kind::kNumber, value); // always finite: the parser refuses other numbers
  }
  bool string(std::string& value) override {
    Json* added = add(Json::Kind::kText);
    if (added)
      added->text = one_line(code_points_as_bytes(value));
    return added != nullptr;
  }
  bool binary(Parser::binary_t&) override { return false; } // JSON has no binary values
  bool start_object(std::size_t) override { return open(Json::Kind::kObject); }
  bool key(std::string& name) override {
    open_.back()->keys.push_back(one_line(code_points_as_bytes(name)));
    return true;
  }
  bool end_object() override { return close(); }
  bool start_array(std::size_t) override { return open(Json::Kind::kList); }
  bool end_array() override { return close(); }
  bool parse_error(std::size_t, const std::string&, const Parser::exception&) override {
    return false;
  }

private:
  Json* add(Json::Kind kind) {
    if (open_.size() > kMaxDepth)
      return nullptr;
    Json& added = open_.empty() ? root_ : open_.back()->list.emplace_back();
    added.kind = kind;
    return &added;
  }
  bool number(Json::Kind kind, double value) {
    Json* added = add(kind);
    if (added)
      added->number = value;
    return added != nullptr;
  }
  bool open(Json::Kind kind) {
    Json* added = add(kind);
    if (added)
      open_.push_back(added);
    return added != nullptr;
  }
  bool close() {
    open_.pop_back();
    return true;
  }

  Json& root_;
  // A value is appended to the innermost container only, so the addresses of the others stay valid.
  std::vector<Json*> open_;
};

} // namespace

const Json* Json::find(std::string_view name) const noexcept {
  for (std::size_t i = 0; i < keys.size(); ++i)
    if (keys[i] == name)
      return &list[i];
  return nullptr;
}

double Json::number_or(std::string_view name, double otherwise) const noexcept {
  const Json* value = find(name);
  return value && value->kind == Kind::kNumber ? value->number : otherwise;
}

std::string Json::text_or(std::string_view name, std::string_view otherwise) const {
  const Json* value = find(name);
  return value && value->kind == Kind::kText ? value->text : std::string(otherwise);
}

bool read_json(std::string_view text, Json& value) {
  value = {};
  Builder builder(value);
  return Parser::sax_parse(bytes_as_code_points(text), &builder);
}

std::string quoted_json(std::string_view text) {
  return code_points_as_bytes(Parser(bytes_as_code_points(text)).dump());
}

} // namespace tactus::files
