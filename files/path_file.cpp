#include "files/path_file.hpp"

#include "core/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactus::files {
namespace {

constexpr std::size_t kMaxRows = 2'000'000;
constexpr double kFarthest_mm = 1e5;

/// Appends the row of a line. Returns an empty text, or the reason why the line is not a valid next
/// row. An empty line adds no row and is no error.
std::string add_row(std::string_view line, std::vector<haptic::PathRow>& rows) {
  std::array<double, 5> values{};
  const auto words = split_words(line, ",");
  if (words.empty())
    return {};
  for (std::size_t i = 0; i < words.size() && i < values.size(); ++i) {
    const auto value = to_number(words[i]);
    if (!value || words.size() < 4 || words.size() > 5)
      return "expected ms x y z [buttonmask]";
    values[i] = *value;
  }
  const auto far = [](double mm) { return std::abs(mm) > kFarthest_mm; };
  if (far(values[1]) || far(values[2]) || far(values[3]))
    return "a position is outside -100000..100000 mm";
  if (values[4] < 0 || values[4] > 4294967295.0 || values[4] != std::floor(values[4]))
    return "the button mask is not an integer in 0..4294967295";
  const double time_s = values[0] * 1e-3;
  if (!rows.empty() && time_s < rows.back().time_s)
    return "time goes backwards";
  if (rows.size() == kMaxRows)
    return "expected at most 2000000 rows";
  rows.push_back({time_s,
                  {values[1] * 1e-3, values[2] * 1e-3, values[3] * 1e-3},
                  static_cast<std::uint32_t>(values[4])});
  return {};
}

} // namespace

ParsedPath parse_path(std::string_view text) {
  ParsedPath result;
  for_each_line(text, [&result](std::size_t number, std::string_view line) {
    const std::string why = add_row(line.substr(0, line.find('#')), result.rows);
    if (!why.empty())
      result = {{}, "line " + std::to_string(number) + ": " + why};
    return why.empty();
  });
  if (result.rows.empty() && result.error.empty())
    result.error = "no row of the form ms x y z [buttonmask]";
  return result;
}

} // namespace tactus::files
