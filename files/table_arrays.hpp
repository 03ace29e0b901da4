#pragma once

#include "core/design/shape_parameters.hpp"
#include "files/json.hpp"
#include "files/npz.hpp"

#include <initializer_list>
#include <string>
#include <vector>

namespace tactus::files {

/// Takes arrays out of an archive by name, type and shape. The first error is kept as a sentence;
/// all later calls do nothing.
class TableArrays {
public:
  explicit TableArrays(const NpzFile& file) : file_(file) {}

  /// Stands for any extent.
  static constexpr std::size_t kAny = static_cast<std::size_t>(-1);

  [[nodiscard]] bool has(std::string_view name) const { return file_.find(name) != nullptr; }
  /// The array, checked; null when it is missing or wrong. `kinds` are NumPy's letters.
  const NpzArray* take(std::string_view name, std::string_view kinds,
                       std::initializer_list<std::size_t> shape);
  /// Real numbers, all finite; empty when the array is missing and not needed.
  std::vector<double> doubles(std::string_view name, std::initializer_list<std::size_t> shape,
                              bool required);
  std::vector<float> floats(std::string_view name, std::initializer_list<std::size_t> shape,
                            bool required);
  /// The table's description, from the array `meta`: the bytes of a JSON object that names `format`
  /// and version 1 or 1.x. `format` consists of words joined by hyphens, as in "modal-table".
  Json description(std::string_view format);
  void refuse(std::string sentence) {
    if (refusal_.empty())
      refusal_ = std::move(sentence);
  }
  [[nodiscard]] bool ok() const noexcept { return refusal_.empty(); }
  [[nodiscard]] const std::string& refusal() const noexcept { return refusal_; }

private:
  template <class T>
  std::vector<T> numbers(std::string_view name, std::initializer_list<std::size_t> shape,
                         bool required, std::vector<T> (NpzArray::*values)() const);

  const NpzFile& file_;
  std::string refusal_;
};

/// Reads `control_points` f8 [C,3] m, `parameters` f8 [P,4] (control point, axis, lowest and
/// highest displacement in m) and `trust` f8 [] m, all required. Errors are stored in `arrays`.
void read_shape_parameters(TableArrays& arrays, const NpzFile& file,
                           design::ShapeParameters& shape);

} // namespace tactus::files
