#include "externals/phantom/device/path_message.hpp"

#include "files/file_bytes.hpp"
#include "files/path_file.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace tactus::phantom {
namespace {

constexpr Range kPeriod{"period", "ms", 1, 1e6};

PathChoice line(Words words) {
  constexpr Range ranges[] = {millimetres("x1"),
                              millimetres("y1"),
                              millimetres("z1"),
                              millimetres("x2"),
                              millimetres("y2"),
                              millimetres("z2"),
                              kPeriod};
  double v[7] = {};
  std::string refusal = read_numbers(words, ranges, v);
  return {haptic::LinePath{metres(v), metres(v + 3), v[6] * 1e-3}, std::move(refusal)};
}

PathChoice circle(Words words) {
  constexpr Range ranges[] = {millimetres("cx"),
                              millimetres("cy"),
                              millimetres("cz"),
                              {"radius", "mm", 0, kMaxCoordinate_mm},
                              kPeriod};
  double v[5] = {};
  std::string refusal = read_numbers(words, ranges, v);
  haptic::CirclePath path{metres(v), v[3] * 1e-3, v[4] * 1e-3, 0, 1};
  if (words.size() > 5) {
    if (is(words[5], "yz"))
      path.first = 1, path.second = 2;
    else if (is(words[5], "xz"))
      path.second = 2;
    else if (!is(words[5], "xy"))
      refusal = expected("plane", words[5], "xy, yz or xz");
  }
  return {path, std::move(refusal)};
}

PathChoice lissajous(Words words) {
  constexpr Range ranges[] = {millimetres("cx"),    millimetres("cy"),    millimetres("cz"),
                              millimetres("ax"),    millimetres("ay"),    millimetres("az"),
                              {"fx", "Hz", 0, 100}, {"fy", "Hz", 0, 100}, {"fz", "Hz", 0, 100}};
  double v[9] = {};
  std::string refusal = read_numbers(words, ranges, v);
  return {haptic::LissajousPath{metres(v), metres(v + 3), {v[6], v[7], v[8]}}, std::move(refusal)};
}

PathChoice arrays(Words words, const Host& host) {
  if (words.size() < 3 || words.size() > 4 || !words[0].is_word || !words[1].is_word ||
      !words[2].is_word)
    return {{}, "expected three array names, then the ms between elements"};
  constexpr Range ranges[] = {{"step", "ms", 0.01, 10000}};
  double step_ms = 1;
  if (words.size() == 4)
    if (std::string refusal = read_numbers(words.subspan(3), ranges, &step_ms); !refusal.empty())
      return {{}, std::move(refusal)};
  std::array<std::vector<double>, 3> columns;
  for (std::size_t axis = 0; axis < 3; ++axis)
    if (!host.read_array(words[axis].word, columns[axis]) || columns[axis].empty())
      return {{}, "no array named " + std::string(words[axis].word)};
  const std::size_t count = std::min({columns[0].size(), columns[1].size(), columns[2].size()});
  std::vector<haptic::PathRow> rows;
  rows.reserve(count);
  for (std::size_t i = 0; i < count; ++i) {
    const double mm[] = {columns[0][i], columns[1][i], columns[2][i]};
    const Vec3 position = metres(mm);
    if (!is_finite(position) || norm(position) > kMaxCoordinate_mm * 1e-3)
      return {{}, "element " + std::to_string(i) + ": expected a position within 10000 mm"};
    rows.push_back({static_cast<double>(i) * step_ms * 1e-3, position, 0});
  }
  return {haptic::RowPath(std::move(rows)), {}};
}

PathChoice file(std::string_view name, const Host& host) {
  const std::string found = host.find_file(name);
  if (found.empty())
    return {{},
            "file not found beside the patch or in the search path; or use line, circle, lissajous "
            "or array"};
  std::string text;
  if (std::string refusal = files::read_file(found, text, files::kMaxPathBytes); !refusal.empty())
    return {{}, std::move(refusal)};
  files::ParsedPath parsed = files::parse_path(text);
  if (!parsed.error.empty())
    return {{}, std::move(parsed.error)};
  return {haptic::RowPath(std::move(parsed.rows)), {}};
}

} // namespace

PathChoice choose_path(Words words, const Host& host) {
  if (!words[0].is_word)
    return {{}, expected("path", words[0], "a file name, line, circle, lissajous or array")};
  const std::string_view kind = words[0].word;
  const Words rest = words.subspan(1);
  PathChoice choice = kind == "line"        ? line(rest)
                      : kind == "circle"    ? circle(rest)
                      : kind == "lissajous" ? lissajous(rest)
                      : kind == "array"     ? arrays(rest, host)
                                            : file(kind, host);
  if (!choice.refusal.empty())
    choice.refusal = "path " + std::string(kind) + ": " + choice.refusal;
  return choice;
}

} // namespace tactus::phantom
