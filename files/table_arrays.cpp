#include "files/table_arrays.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::files {
namespace {

std::string text_of(std::span<const std::size_t> shape) {
  std::string text = "(";
  for (std::size_t i = 0; i < shape.size(); ++i)
    text += (i ? ", " : "") +
            (shape[i] == TableArrays::kAny ? std::string("any") : std::to_string(shape[i]));
  return text + ")";
}

} // namespace

const NpzArray* TableArrays::take(std::string_view name, std::string_view kinds,
                                  std::initializer_list<std::size_t> shape) {
  if (!ok())
    return nullptr;
  const NpzArray* array = file_.find(name);
  const std::string named = "array '" + std::string(name) + "' ";
  if (!array) {
    refuse(named + "is missing");
    return nullptr;
  }
  if (kinds.find(array->kind) == std::string_view::npos) {
    refuse(named + "has the wrong type of numbers");
    return nullptr;
  }
  const bool matches =
      array->shape.size() == shape.size() &&
      std::equal(shape.begin(), shape.end(), array->shape.begin(),
                 [](std::size_t want, std::size_t is) { return want == kAny || want == is; });
  if (!matches) {
    refuse(named + "has shape " + text_of(array->shape) + ": expected " +
           text_of({shape.begin(), shape.size()}));
    return nullptr;
  }
  return array;
}

Json TableArrays::description(std::string_view format) {
  Json json;
  const NpzArray* meta = take("meta", "u", {kAny});
  if (!meta)
    return json;
  constexpr std::size_t kMaxBytes = 1u << 20; // parsed JSON takes eighty times the memory of its
                                              // text
  if (meta->bytes.size() > kMaxBytes) {
    refuse("array 'meta' has " + std::to_string(meta->bytes.size()) + " bytes: expected at most " +
           std::to_string(kMaxBytes));
    return json;
  }
  if (meta->item_bytes != 1) {
    refuse("array 'meta': expected JSON as bytes (uint8)");
    return json;
  }
  const std::string_view text(reinterpret_cast<const char*>(meta->bytes.data()),
                              meta->bytes.size());
  if (!read_json(text, json) || json.kind != Json::Kind::kObject) {
    refuse("array 'meta' is not JSON");
    return json;
  }
  std::string words(format);
  std::replace(words.begin(), words.end(), '-', ' ');
  if (const std::string found = json.text_or("format", ""); found != format)
    refuse("it is not a " + words + ": meta says format '" + found + "', expected '" +
           std::string(format) + "'");
  else if (const std::string version = json.text_or("version", "");
           version != "1" && !version.starts_with("1."))
    refuse("table version '" + version + "': this release reads version 1");
  return json;
}

template <class T>
std::vector<T> TableArrays::numbers(std::string_view name, std::initializer_list<std::size_t> shape,
                                    bool required, std::vector<T> (NpzArray::*values)() const) {
  if (!required && !has(name))
    return {};
  const NpzArray* array = take(name, "fiu", shape);
  if (!array)
    return {};
  std::vector<T> found = (array->*values)();
  if (!std::all_of(found.begin(), found.end(), [](T x) { return std::isfinite(x); }))
    refuse("array '" + std::string(name) + "': not a finite number");
  return found;
}

std::vector<double> TableArrays::doubles(std::string_view name,
                                         std::initializer_list<std::size_t> shape, bool required) {
  return numbers(name, shape, required, &NpzArray::values);
}

std::vector<float> TableArrays::floats(std::string_view name,
                                       std::initializer_list<std::size_t> shape, bool required) {
  return numbers(name, shape, required, &NpzArray::single_values);
}

} // namespace tactus::files
