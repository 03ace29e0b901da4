#include "core/haptic/device/path.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <numbers>
#include <utility>

namespace tactus::haptic {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;
constexpr std::size_t kMaxRows = 2'000'000;
constexpr double kMaxPosition_mm = 1e5;

// Whole periods are removed before the product with 2 pi, so that the sine is exact after hours.
double phase_of(double turns) noexcept { return kTwoPi * (turns - std::floor(turns)); }

bool is_blank(char c) noexcept { return c == ' ' || c == '\t' || c == '\r' || c == ','; }

/// Reads the numbers of one line and returns their count; -1 for anything else, or more than 5.
int parse_numbers(std::string_view line, std::array<double, 5>& values) noexcept {
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

PathPoint RowPath::at(double time_s) const noexcept {
  if (rows_.empty())
    return {};
  const auto after = std::upper_bound(rows_.begin(), rows_.end(), time_s,
                                      [](double t, const PathRow& row) { return t < row.time_s; });
  if (after == rows_.begin())
    return {after->position, {}, after->buttons};
  const auto before = std::prev(after);
  if (after == rows_.end())
    return {before->position, {}, before->buttons};
  const double span_s = after->time_s - before->time_s;
  const Vec3 displacement = after->position - before->position;
  const double fraction = (time_s - before->time_s) / span_s;
  return {before->position + displacement * fraction, displacement * (1.0 / span_s),
          before->buttons};
}

PathPoint LinePath::at(double time_s) const noexcept {
  const double phase = phase_of(time_s / period_s);
  const Vec3 displacement = to - from;
  return {from + displacement * (0.5 * (1.0 - std::cos(phase))),
          displacement * (0.5 * std::sin(phase) * kTwoPi / period_s), 0};
}

PathPoint CirclePath::at(double time_s) const noexcept {
  const double phase = phase_of(time_s / period_s);
  const double speed = radius_m * kTwoPi / period_s;
  PathPoint point;
  point.position = centre;
  point.position[first] += radius_m * std::cos(phase);
  point.position[second] += radius_m * std::sin(phase);
  point.velocity[first] = -speed * std::sin(phase);
  point.velocity[second] = speed * std::cos(phase);
  return point;
}

PathPoint LissajousPath::at(double time_s) const noexcept {
  PathPoint point;
  for (int axis = 0; axis < 3; ++axis) {
    const double phase = phase_of(frequency_hz[axis] * time_s);
    point.position[axis] = centre[axis] + amplitude[axis] * std::sin(phase);
    point.velocity[axis] = amplitude[axis] * kTwoPi * frequency_hz[axis] * std::cos(phase);
  }
  return point;
}

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
    const int count = parse_numbers(line, values);
    if (count == 0)
      continue;
    if (count != 4 && count != 5) {
      refuse(number, "expected ms x y z [buttonmask]");
      return result;
    }
    const auto out_of_range = [](double mm) { return std::abs(mm) > kMaxPosition_mm; };
    if (out_of_range(values[1]) || out_of_range(values[2]) || out_of_range(values[3])) {
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

} // namespace tactus::haptic
