#include "core/haptic/scene/mesh_file.hpp"

#include <bit>
#include <charconv>
#include <cstring>

namespace tactus::haptic {
namespace {

constexpr std::size_t kMaxTriangles = 4'000'000;
constexpr std::size_t kHeader = 84, kRecord = 50; // bytes of a binary STL

std::uint32_t read_uint32(std::string_view bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 4; i-- > 0;)
    word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= kHeader &&
         bytes.size() == kHeader + kRecord * static_cast<std::size_t>(read_uint32(bytes, 80));
}

ParsedMesh parse_binary_stl(std::string_view bytes) {
  ParsedMesh mesh;
  const std::uint32_t count = read_uint32(bytes, 80);
  if (count > kMaxTriangles)
    return {{}, {}, "has more than 4 million triangles"};
  mesh.corners.reserve(3 * std::size_t{count});
  mesh.triangles.reserve(count);
  for (std::size_t t = 0; t < count; ++t) {
    const std::size_t record = kHeader + t * kRecord + 12; // after the normal
    for (std::size_t corner = 0; corner < 3; ++corner) {
      Vec3 point;
      for (int axis = 0; axis < 3; ++axis)
        point[axis] = static_cast<double>(std::bit_cast<float>(
            read_uint32(bytes, record + 12 * corner + 4 * static_cast<std::size_t>(axis))));
      if (!is_finite(point))
        return {{}, {}, "triangle " + std::to_string(t + 1) + " has a corner that is no number"};
      mesh.corners.push_back(point);
    }
    const auto first = static_cast<std::uint32_t>(3 * t);
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  return mesh;
}

/// Words of one line, from the left.
class Tokenizer {
public:
  explicit Tokenizer(std::string_view line) : remaining_(line) {}
  std::string_view next() {
    const std::size_t begin = remaining_.find_first_not_of(" \t\r");
    if (begin == std::string_view::npos)
      return remaining_ = {};
    remaining_.remove_prefix(begin);
    const std::string_view word = remaining_.substr(0, remaining_.find_first_of(" \t\r"));
    remaining_.remove_prefix(word.size());
    return word;
  }
  bool point(Vec3& p) {
    for (int axis = 0; axis < 3; ++axis) {
      const std::string_view word = next();
      const auto read = std::from_chars(word.data(), word.data() + word.size(), p[axis]);
      if (read.ec != std::errc())
        return false;
    }
    return is_finite(p);
  }

private:
  std::string_view remaining_;
};

/// "7", "7/1", "7//2", "-1": which corner, from 0; false when there is none such.
bool parse_corner(std::string_view word, std::size_t count, std::uint32_t& corner) {
  long long number = 0;
  const auto read = std::from_chars(word.data(), word.data() + word.size(), number);
  if (read.ec != std::errc() || (read.ptr != word.data() + word.size() && *read.ptr != '/'))
    return false;
  const long long index = number > 0 ? number - 1 : static_cast<long long>(count) + number;
  if (number == 0 || index < 0 || index >= static_cast<long long>(count))
    return false;
  corner = static_cast<std::uint32_t>(index);
  return true;
}

ParsedMesh parse_text_mesh(std::string_view text) {
  ParsedMesh mesh;
  std::size_t number = 0;
  const auto fail = [&](std::string_view what) {
    return ParsedMesh{{}, {}, "line " + std::to_string(number) + ": " + std::string(what)};
  };
  std::uint32_t loop = 0; // corners of an STL facet so far
  while (!text.empty()) {
    const std::size_t end = text.find('\n');
    Tokenizer words(text.substr(0, end));
    text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
    ++number;
    const std::string_view kind = words.next();
    if (kind == "v" || kind == "vertex") {
      Vec3 point;
      if (!words.point(point))
        return fail("expected three numbers");
      mesh.corners.push_back(point);
      if (kind == "vertex" && ++loop == 3) {
        const auto count = static_cast<std::uint32_t>(mesh.corners.size());
        mesh.triangles.push_back({count - 3, count - 2, count - 1});
      }
    } else if (kind == "facet" || kind == "outer") {
      loop = 0;
    } else if (kind == "f") {
      std::uint32_t first = 0, before = 0, corner = 0;
      int size = 0;
      for (std::string_view word = words.next(); !word.empty(); word = words.next(), ++size) {
        if (!parse_corner(word, mesh.corners.size(), corner))
          return fail("a face has no corner " + std::string(word));
        if (size == 0)
          first = corner;
        if (size >= 2)
          mesh.triangles.push_back({first, before, corner});
        before = corner;
      }
      if (size < 3)
        return fail("a face needs three corners");
    }
    if (mesh.triangles.size() > kMaxTriangles)
      return {{}, {}, "has more than 4 million triangles"};
  }
  if (mesh.triangles.empty())
    mesh.error = "holds no triangles; expected an STL or OBJ file";
  return mesh;
}

} // namespace

ParsedMesh parse_mesh(std::string_view bytes) {
  return is_binary_stl(bytes) ? parse_binary_stl(bytes) : parse_text_mesh(bytes);
}

} // namespace tactus::haptic
