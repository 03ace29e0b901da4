#include "fem/io/triangles.hpp"

#include "fem/io/obj.hpp"
#include "fem/io/stl.hpp"
#include "fem/io/text.hpp"

#include <fstream>
#include <iterator>
#include <numbers>

namespace tactus::fem {
namespace {

/// Text with its byte order mark removed; UTF-16 becomes ASCII, other letters question marks.
std::string plain_text(std::string bytes) {
  if (bytes.starts_with("\xEF\xBB\xBF"))
    return bytes.substr(3);
  const bool big = bytes.starts_with("\xFE\xFF"), little = bytes.starts_with("\xFF\xFE");
  if (!big && !little)
    return bytes;
  std::string text;
  for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) {
    const char high = bytes[big ? i : i + 1], low = bytes[big ? i + 1 : i];
    text += high == 0 && static_cast<unsigned char>(low) < 128 ? low : '?';
  }
  return text;
}

} // namespace

std::string near_position(const Vector3& p) {
  return format(" near (%.4g, %.4g, %.4g) mm", 1e3 * p.x, 1e3 * p.y, 1e3 * p.z);
}

std::string triangle_location(const Triangles& t, std::size_t i) {
  return "triangle " + std::to_string(i + 1) + near_position(t.corner(i, 0));
}

Triangles read_triangles(const std::string& path, double unit) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw InputError("cannot read " + path);
  const std::string bytes = plain_text({std::istreambuf_iterator<char>(file), {}});
  Triangles out =
      lower(path).ends_with(".obj") ? read_obj(path, bytes, unit) : read_stl(path, bytes, unit);
  if (out.triangles.empty())
    throw InputError(path + " holds no triangle");
  return out;
}

double share_of_slivers(const Triangles& t, double degrees) {
  const double limit = std::cos(degrees * std::numbers::pi / 180);
  std::size_t slivers = 0;
  for (std::size_t i = 0; i < t.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) {
      const Vector3 p = t.corner(i, k), a = t.corner(i, k + 1) - p, b = t.corner(i, k + 2) - p;
      if (dot(a, b) > limit * length(a) * length(b)) {
        ++slivers;
        break;
      }
    }
  return static_cast<double>(slivers) / static_cast<double>(t.triangles.size());
}

} // namespace tactus::fem
