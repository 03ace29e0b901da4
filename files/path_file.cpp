#include "files/path_file.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace tactus::files {
namespace {

constexpr std::size_t kMaxRows = 2'000'000;
constexpr double kFarthest_mm = 1e5;

bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r' || c == ','; }

/// Numbers of one line; -1 when something else stands there or they are too many.
int numbers_of(std::string_view line, std::array<double, 5>& values) noexcept {
  int count = 0;
  std::size_t offset = 0;
  while (true) {
    while (offset < line.size() && is_blank(line[offset]))
      ++offset;
    if (offset == line.size())
      return count;
    if (count == 5)
      return -1;
    if (line[offset] == '+')
      ++offset;
    double value = 0;
    const auto [end, problem] =
        std::from_chars(line.data() + offset, line.data() + line.size(), value);
    if (problem != std::errc{} || !std::isfinite(value))
      return -1;
    offset = static_cast<std::size_t>(end - line.data());
    if (offset < line.size() && !is_blank(line[offset]))
      return -1;
    values[static_cast<std::size_t>(count++)] = value;
  }
}

} // namespace

ParsedPath parse_path(std::string_view text) {
  ParsedPath result;
  const auto refuse = [&result](std::size_t line, const char* why) {
    result.rows.clear();
    result.error = "line " + std::to_string(line) + ": " + why;
  };
  std::size_t number = 0;
  while (!text.empty()) {
    ++number;
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    line = line.substr(0, std::min(line.find('#'), line.size()));
    std::array<double, 5> values{};
    const int count = numbers_of(line, values);
    if (count == 0)
      continue;
    if (count != 4 && count != 5) {
      refuse(number, "expected ms x y z [buttonmask]");
      return result;
    }
    const auto far = [](double mm) { return std::abs(mm) > kFarthest_mm; };
    if (far(values[1]) || far(values[2]) || far(values[3])) {
      refuse(number, "a position is beyond 100000 mm");
      return result;
    }
    if (values[4] < 0 || values[4] > 4294967295.0 || values[4] != std::floor(values[4])) {
      refuse(number, "the button mask is not a whole number from 0 to 4294967295");
      return result;
    }
    const double time_s = values[0] * 1e-3;
    if (!result.rows.empty() && time_s < result.rows.back().time_s) {
      refuse(number, "time goes backwards");
      return result;
    }
    if (result.rows.size() == kMaxRows) {
      refuse(number, "more than 2000000 rows");
      return result;
    }
    result.rows.push_back({time_s,
                           {values[1] * 1e-3, values[2] * 1e-3, values[3] * 1e-3},
                           static_cast<std::uint32_t>(values[4])});
  }
  if (result.rows.empty())
    result.error = "no row of the form ms x y z [buttonmask]";
  return result;
}

} // namespace tactus::files
