#include "programs/part_stress/region.hpp"

#include "fem/io/load.hpp"
#include "fem/io/text.hpp"

namespace tactus::fem {

namespace {
constexpr double kMaxNumber = 1e15;
} // namespace

std::vector<double> read_numbers(const std::string& option, const std::string& cells,
                                 std::size_t count, double scale) {
  std::vector<double> out;
  for (const std::string& cell : split(cells, ',')) {
    const auto value = to_number(cell);
    if (!value)
      throw InputError(option + ": " + printable(cell, 40) + ": not a finite number, expected " +
                       std::to_string(count) + " between commas");
    if (std::abs(*value) > kMaxNumber)
      throw InputError(option + ": " + printable(cell, 40) + ": expected a number in -1e15..1e15");
    out.push_back(scale * *value);
  }
  if (out.size() != count)
    throw InputError(option + ": " + printable(cells, 60) + " has " + std::to_string(out.size()) +
                     " numbers, expected " + std::to_string(count));
  return out;
}

Vec3 read_vector(const std::string& option, const std::string& cells, double scale) {
  const auto v = read_numbers(option, cells, 3, scale);
  return {v[0], v[1], v[2]};
}

Region read_region(const std::string& option, std::vector<std::string>& parts, double unit) {
  Region region;
  const std::string kind = parts.empty() ? "" : parts[0];
  const auto take = [&](std::size_t count) {
    if (parts.size() < count)
      throw InputError(option + " " + kind + ": expected more after the colon; see --help");
    for (std::size_t i = 0; i < count; ++i)
      region.words += (i ? ":" : "") + parts[i];
    std::string last = parts[count - 1];
    parts.erase(parts.begin(), parts.begin() + static_cast<std::ptrdiff_t>(count));
    return last;
  };
  auto& chosen = region.selection.region;
  const auto numbers = [&](std::size_t count) {
    return read_numbers(option + " " + kind, take(2), count, unit);
  };
  if (kind == "box") {
    const auto v = numbers(6);
    chosen = InBox{{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}}};
  } else if (kind == "plane") {
    const auto v = numbers(6);
    chosen = OnPlane{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}};
  } else if (kind == "cylinder") {
    const auto v = numbers(7);
    chosen = OnCylinder{{v[0], v[1], v[2]}, {v[3], v[4], v[5]}, v[6]};
  } else if (kind == "sphere") {
    const auto v = numbers(4);
    chosen = OnSphere{{v[0], v[1], v[2]}, v[3]};
  } else if (kind == "set") {
    chosen = InNodeSet{take(2)};
  } else if (kind == "face") {
    const std::string word = take(2);
    const auto face = to_number<int>(word);
    if (!face || *face < 1)
      throw InputError(option + " face:" + printable(word, 40) +
                       ": expected a number of 1 or more, as listed by "
                       "--list-faces");
    chosen = InNodeSet{face_set(*face)};
  } else if (kind.size() > 2 && kind[1] == '=' && kind[0] >= 'x' && kind[0] <= 'z') {
    OnPlane plane;
    const int axis = take(1)[0] - 'x';
    plane.point[axis] = read_numbers(option, kind.substr(2), 1, unit)[0];
    plane.normal[axis] = 1;
    chosen = plane;
  } else if (split(kind, ',').size() == 4 && to_number(split(kind, ',')[0])) {
    const auto v = read_numbers(option, take(1), 4, unit);
    chosen = OnSphere{{v[0], v[1], v[2]}, v[3], true};
  } else {
    throw InputError(
        option + " " + printable(kind, 60) +
        ": expected x=LEVEL, box:, plane:, cylinder:, sphere:, set:, face: or X,Y,Z,R");
  }
  return region;
}

std::string usage_of_regions() {
  return R"(WHERE is      x=LEVEL  plane:X,Y,Z,NX,NY,NZ  box:X1,Y1,Z1,X2,Y2,Z2  set:NAME  face:N
              cylinder:X1,Y1,Z1,X2,Y2,Z2,R  (the wall of a hole or pin)  sphere:X,Y,Z,R
              X,Y,Z,R  (all nodes in a ball)
)";
}

} // namespace tactus::fem
