#include "fem/io/obj.hpp"

#include "fem/io/text_lines.hpp"

#include <numeric>
#include <set>

namespace tactus::fem {
namespace {

constexpr std::size_t kMaxCorners = 4096; ///< of a polygon: cutting ears takes their square

using Point2 = std::array<double, 2>;

double turn(const Point2& a, const Point2& b, const Point2& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

/// Corners in the plane of the polygon's mean normal (Newell), turning to the left.
std::vector<Point2> flattened(std::span<const Vector3> corners) {
  Vector3 normal;
  for (std::size_t i = 0; i < corners.size(); ++i)
    normal += cross(corners[i] - corners[0], corners[(i + 1) % corners.size()] - corners[0]);
  const double size = length(normal);
  normal = size > 0 ? (1 / size) * normal : Vector3{0, 0, 1};
  const Vector3 other = std::abs(normal.x) < .6 ? Vector3{1, 0, 0} : Vector3{0, 1, 0};
  Vector3 x = cross(other, normal);
  x = (1 / length(x)) * x;
  const Vector3 y = cross(normal, x);
  std::vector<Point2> flat;
  flat.reserve(corners.size());
  for (const Vector3& p : corners)
    flat.push_back({dot(x, p - corners[0]), dot(y, p - corners[0])});
  return flat;
}

/// Joins lines that end with a backslash; the line numbers after them stay.
std::string join_continued_lines(std::string text) {
  std::size_t skipped = 0;
  for (std::size_t i = 0; i < text.size(); ++i)
    if (text[i] == '\\') {
      const std::size_t end = text.find_first_not_of(" \t\r", i + 1);
      if (end != std::string::npos && text[end] == '\n') {
        std::fill(text.begin() + static_cast<std::ptrdiff_t>(i),
                  text.begin() + static_cast<std::ptrdiff_t>(end + 1), ' ');
        ++skipped;
      }
    } else if (text[i] == '\n' && skipped > 0) {
      text.insert(i, skipped, '\n');
      i += skipped;
      skipped = 0;
    }
  return text;
}

} // namespace

std::vector<std::array<int, 3>> clip_ears(std::span<const Vector3> corners) {
  const std::vector<Point2> flat = flattened(corners);
  std::vector<int> left(corners.size());
  std::iota(left.begin(), left.end(), 0);
  std::vector<std::array<int, 3>> triangles;
  const auto at = [&](int i) -> const Point2& { return flat[static_cast<std::size_t>(i)]; };
  const auto is_ear = [&](int a, int b, int c) {
    if (!(turn(at(a), at(b), at(c)) > 0))
      return false;
    for (const int p : left) {
      if (p == a || p == b || p == c || at(p) == at(a) || at(p) == at(b) || at(p) == at(c))
        continue;
      if (turn(at(a), at(b), at(p)) >= 0 && turn(at(b), at(c), at(p)) >= 0 &&
          turn(at(c), at(a), at(p)) >= 0)
        return false;
    }
    return true;
  };
  while (left.size() > 3) {
    // Of all ears the one with the shortest new edge: fans would leave slivers. Of very many
    // corners the first, for time.
    std::size_t best = left.size();
    double shortest = 0;
    for (std::size_t i = 0; i < left.size(); ++i) {
      const int a = left[i], b = left[(i + 1) % left.size()], c = left[(i + 2) % left.size()];
      const double size =
          length(corners[static_cast<std::size_t>(c)] - corners[static_cast<std::size_t>(a)]);
      if ((best == left.size() || size < shortest) && is_ear(a, b, c)) {
        best = i;
        shortest = size;
        if (left.size() > 200)
          break;
      }
    }
    if (best == left.size())
      best = 0; // crosses itself or has no area: any corner
    const std::size_t tip = (best + 1) % left.size();
    triangles.push_back({left[best], left[tip], left[(best + 2) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(tip));
  }
  if (left.size() == 3)
    triangles.push_back({left[0], left[1], left[2]});
  return triangles;
}

Triangles read_obj(const std::string& path, const std::string& text, double unit) {
  static const std::set<std::string_view> free_form{"curv", "curv2", "surf", "bmat", "cstype"};
  Triangles out;
  bool objects = false;
  std::size_t lines = 0, single_points = 0;
  const auto start_group = [&](std::string_view name) {
    out.groups.emplace_back(name.empty() ? "part" + std::to_string(out.groups.size() + 1)
                                         : std::string(name));
  };
  for_each_line(join_continued_lines(text), [&](int number, Tokens tokens) {
    const std::string_view kind = tokens.next();
    const std::string location = path + " line " + std::to_string(number) + ": ";
    if (kind == "v") {
      out.points.push_back(unit * read_point(tokens, path, number));
    } else if (kind == "o" || (kind == "g" && !objects)) {
      if (kind == "o" && !objects && out.triangles.empty())
        out.groups.clear();
      objects = objects || kind == "o";
      start_group(tokens.rest_of_line());
    } else if (free_form.contains(kind)) {
      throw InputError(location + "\"" + std::string(kind) +
                       "\" is a free-form curve or surface, expected polygons (f): export the body "
                       "as polygons, or as STEP");
    } else if (kind == "l") {
      ++lines;
    } else if (kind == "p") {
      ++single_points;
    } else if (kind == "f") {
      std::vector<int> face;
      std::vector<Vector3> corners;
      for (std::string_view word = tokens.next(); !word.empty() && word[0] != '#';
           word = tokens.next()) {
        const auto index = to_integer(word.substr(0, word.find('/')));
        const int count = static_cast<int>(out.points.size());
        const int at = index ? (*index < 0 ? count + *index : *index - 1) : -1;
        if (at < 0 || at >= count)
          throw InputError(location + "vertex " + std::string(word) + " does not exist");
        face.push_back(at);
        corners.push_back(out.points[static_cast<std::size_t>(at)]);
      }
      if (face.size() < 3 || face.size() > kMaxCorners)
        throw InputError(location + "a face with " + std::to_string(face.size()) +
                         " corners, expected 3 to " + std::to_string(kMaxCorners));
      if (out.groups.empty())
        start_group("");
      for (const auto& ear : clip_ears(corners)) {
        std::array<int, 3> triangle{};
        for (std::size_t k = 0; k < 3; ++k)
          triangle[k] = face[static_cast<std::size_t>(ear[k])];
        out.triangles.push_back(triangle);
        out.group.push_back(static_cast<int>(out.groups.size()) - 1);
      }
    }
  });
  if (out.triangles.empty() && lines + single_points > 0)
    throw InputError(path + " holds " + std::to_string(lines) + " lines and " +
                     std::to_string(single_points) +
                     " points and no face: expected the polygons (f) of a closed surface");
  return out;
}

} // namespace tactus::fem
