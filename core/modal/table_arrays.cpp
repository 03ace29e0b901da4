#include "core/modal/table_arrays.hpp"

#include <algorithm>
#include <cmath>

namespace tactus::modal {
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
  if (!good())
    return nullptr;
  const NpzArray* array = file_.find(name);
  const std::string named = "array '" + std::string(name) + "' ";
  if (!array) {
    refuse(named + "is missing");
    return nullptr;
  }
  if (kinds.find(array->kind) == std::string_view::npos) {
    refuse(named + "holds the wrong kind of numbers");
    return nullptr;
  }
  const bool fits =
      array->shape.size() == shape.size() &&
      std::equal(shape.begin(), shape.end(), array->shape.begin(),
                 [](std::size_t want, std::size_t is) { return want == kAny || want == is; });
  if (!fits) {
    refuse(named + "has shape " + text_of(array->shape) + ": expected " +
           text_of({shape.begin(), shape.size()}));
    return nullptr;
  }
  return array;
}

std::vector<double> TableArrays::reals(std::string_view name,
                                       std::initializer_list<std::size_t> shape, bool needed) {
  if (!needed && !has(name))
    return {};
  const NpzArray* array = take(name, "fiu", shape);
  if (!array)
    return {};
  std::vector<double> values = array->values();
  if (!std::all_of(values.begin(), values.end(), [](double x) { return std::isfinite(x); }))
    refuse("array '" + std::string(name) + "' holds numbers that are not finite");
  return values;
}

std::vector<float> TableArrays::singles(std::string_view name,
                                        std::initializer_list<std::size_t> shape, bool needed) {
  if (!needed && !has(name))
    return {};
  const NpzArray* array = take(name, "fiu", shape);
  if (!array)
    return {};
  std::vector<float> values = array->single_values();
  if (!std::all_of(values.begin(), values.end(), [](float x) { return std::isfinite(x); }))
    refuse("array '" + std::string(name) + "' holds numbers that are not finite");
  return values;
}

} // namespace tactus::modal
