// JSON of tables: what is read is bounded and one line a text, and texts can be written again.
#include "files/json.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <algorithm>
#include <cmath>

using tactus::files::Json;
using tactus::fuzz::check;

namespace {

void check_value(const Json& value, int depth) {
  check(depth <= 32, "a value lies deeper than 32 levels");
  check(std::isfinite(value.number), "a number is not finite");
  check(value.keys.size() == (value.kind == Json::Kind::kObject ? value.list.size() : 0),
        "an object has another number of names than of values");
  const auto is_control = [](char c) { return static_cast<unsigned char>(c) < 0x20; };
  check(std::none_of(value.text.begin(), value.text.end(), is_control),
        "a text has control characters");
  if (value.kind == Json::Kind::kText) {
    Json again;
    check(read_json(tactus::files::quoted_json(value.text), again) && again.text == value.text,
          "a text that is written is read as another");
  }
  for (const Json& element : value.list)
    check_value(element, depth + 1);
}

} // namespace

void tactus::fuzz::decode(std::span<const std::uint8_t> input) {
  const std::string_view text(reinterpret_cast<const char*>(input.data()), input.size());
  Json value;
  if (files::read_json(text, value))
    check_value(value, 0);
}
