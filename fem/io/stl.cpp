#include "fem/io/stl.hpp"

#include "fem/io/text_lines.hpp"

#include <cstdint>
#include <cstring>

namespace tactus::fem {
namespace {

constexpr std::size_t kHeader = 84, kRecord = 50; ///< bytes

std::size_t binary_count(const std::string& bytes) {
  std::uint32_t count = 0;
  if (bytes.size() >= kHeader)
    std::memcpy(&count, bytes.data() + 80, 4);
  return count;
}

bool is_ascii(const std::string& bytes) {
  const auto start = bytes.find_first_not_of(" \t\r\n");
  if (start == std::string::npos || lower(bytes.substr(start, 5)) != "solid")
    return false;
  if (bytes.size() >= kHeader && bytes.size() == kHeader + kRecord * binary_count(bytes))
    return false;
  const std::string beginning = lower(bytes.substr(0, 1 << 16));
  return beginning.find('\0') == std::string::npos &&
         (beginning.find("facet") != std::string::npos ||
          beginning.find("endsolid") != std::string::npos);
}

Triangles read_binary(const std::string& path, const std::string& bytes, double unit) {
  if (bytes.size() < kHeader)
    throw InputError(path + " is no STL file: it has " + std::to_string(bytes.size()) +
                     " bytes and does not start with \"solid\"");
  const std::size_t there = (bytes.size() - kHeader) / kRecord;
  std::size_t count = binary_count(bytes);
  if (count == 0) // left out by some writers
    count = (bytes.size() - kHeader) % kRecord == 0 ? there : 0;
  if (count > there)
    throw InputError(path + " promises " + std::to_string(count) + " triangles and ends after " +
                     std::to_string(there));
  Triangles out;
  for (std::size_t i = 0; i < count; ++i) {
    std::array<int, 3> triangle{};
    for (std::size_t c = 0; c < 3; ++c) {
      std::array<float, 3> p{};
      std::memcpy(p.data(), bytes.data() + kHeader + kRecord * i + 12 + 12 * c, 12);
      if (!(std::isfinite(p[0]) && std::isfinite(p[1]) && std::isfinite(p[2])))
        throw InputError(path + ": triangle " + std::to_string(i + 1) +
                         " has a corner that is no number");
      triangle[c] = static_cast<int>(out.points.size());
      out.points.push_back({unit * p[0], unit * p[1], unit * p[2]});
    }
    out.triangles.push_back(triangle);
  }
  out.groups = {"solid"};
  out.group.assign(out.triangles.size(), 0);
  return out;
}

Triangles read_ascii(const std::string& path, const std::string& bytes, double unit) {
  Triangles out;
  std::size_t first = 0; // corner of the facet being read
  for_each_line(bytes, [&](int number, Tokens tokens) {
    const std::string word = lower(tokens.next());
    if (word == "solid") {
      const std::string name(tokens.rest_of_line());
      out.groups.push_back(name.empty() ? "solid" + std::to_string(out.groups.size() + 1) : name);
    } else if (word == "vertex") {
      out.points.push_back(unit * read_point(tokens, path, number));
    } else if (word == "endfacet") {
      const std::size_t corners = out.points.size() - first;
      if (corners != 3)
        throw InputError(path + " line " + std::to_string(number) + ": a facet with " +
                         std::to_string(corners) + " corners, expected 3");
      const int a = static_cast<int>(first);
      out.triangles.push_back({a, a + 1, a + 2});
      out.group.push_back(std::max(0, static_cast<int>(out.groups.size()) - 1));
      first = out.points.size();
    }
  });
  if (first != out.points.size())
    throw InputError(path + " ends within a facet");
  return out;
}

} // namespace

Triangles read_stl(const std::string& path, const std::string& bytes, double unit) {
  return is_ascii(bytes) ? read_ascii(path, bytes, unit) : read_binary(path, bytes, unit);
}

} // namespace tactus::fem
